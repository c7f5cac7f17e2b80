// SPDX-License-Identifier: MIT
#include "handyar/evaluation/truth.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <stdexcept>

#include "handyar/io/error.hpp"
#include "handyar/io/json.hpp"
#include "handyar/opencv/aruco.hpp"

namespace handyar::evaluation {
namespace {

using nlohmann::json;

constexpr double kMetresPerMillimetre = 1e-3;
constexpr double kOutstretchedFold = 0.02;  ///< fingers folded less than this count as outstretched
constexpr double kFoldedFold = 0.97;        ///< fingers folded more than this: a fist or a four
constexpr double kAbsentFraction = 0.05;    ///< less of the hand than this in view: it is absent

template <int Rows, int Columns>
Eigen::Matrix<double, Rows, Columns> matrix(const json& j) {
  Eigen::Matrix<double, Rows, Columns> m;
  for (int r = 0; r < Rows; ++r)
    for (int c = 0; c < Columns; ++c) {
      m(r, c) =
          Columns == 1 ? j.at(r).template get<double>() : j.at(r).at(c).template get<double>();
      if (!std::isfinite(m(r, c))) throw std::runtime_error("a number is not finite");
    }
  return m;
}

Eigen::Isometry3d transform(const json& j, const std::string& what) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = matrix<3, 3>(j.at("R_" + what));
  T.translation() = matrix<3, 1>(j.at("t_" + what + "_mm")) * kMetresPerMillimetre;
  return T;
}

Camera camera(const json& j) {
  const Eigen::Matrix3d K = matrix<3, 3>(j.at("K"));
  Camera c;
  c.width_px = j.at("width");
  c.height_px = j.at("height");
  if (c.width_px <= 0 || c.height_px <= 0) throw std::runtime_error("its pictures have no size");
  c.fx_px = K(0, 0);
  c.fy_px = K(1, 1);
  c.cx_px = K(0, 2);
  c.cy_px = K(1, 2);
  if (!(c.fx_px > 0 && c.fy_px > 0)) throw std::runtime_error("K has no focal length");
  const auto dist = j.value("dist", std::vector<double>());
  for (std::size_t i = 0; i < dist.size(); ++i)
    if (i < c.distortion.size())
      c.distortion[i] = dist[i];
    else if (dist[i] != 0)
      throw std::runtime_error("dist has more than k1, k2, p1, p2 and k3");
  return c;
}

/// A length in millimetres, in metres.
double length_m(const json& j) {
  const double mm = j.get<double>();
  if (!(mm > 0)) throw std::runtime_error("a print's size is not positive");
  return mm * kMetresPerMillimetre;
}

Board board(const json& j) {
  const Board b{j.at("inner_corners").at(0), j.at("inner_corners").at(1),
                length_m(j.at("square_mm"))};
  const std::string corners = std::to_string(b.columns) + "x" + std::to_string(b.rows);
  if (!parse_grid(corners))
    throw std::runtime_error("inner_corners, " + corners + ", are not from 3x3 to 50x50");
  return b;
}

Marker marker(const json& j) {
  const Marker m{j.at("dict"), j.at("id"), length_m(j.at("size_mm")), true};
  if (m.is_apriltag() ? m.dictionary != kAprilTagDictionary : !dictionary_number(m.dictionary))
    throw std::runtime_error("markers of " + m.dictionary + " are not known");
  return m;
}

HandModel hand(const json& j) {
  HandModel m;
  for (int finger = 0; finger < kFingerCount; ++finger)
    m.tips_m.col(finger) = matrix<3, 1>(j.at("tips_hand_mm").at(finger)) * kMetresPerMillimetre;
  m.source = HandSource::truth;
  return m;
}

/// On which side the thumb is in the picture, the fingers taken as up (y points down there).
Layout layout_in_picture(const TipsPx& tips) {
  const Eigen::Vector2d up = tips[2] - (tips[0] + tips[4]) / 2, to_thumb = tips[0] - tips[4];
  return up.x() * to_thumb.y() - up.y() * to_thumb.x() > 0 ? Layout::thumb_right
                                                           : Layout::thumb_left;
}

TipsPx tips_px(const json& j) {
  TipsPx tips;
  for (std::size_t finger = 0; finger < tips.size(); ++finger)
    tips[finger] = matrix<2, 1>(j.at("tips_px").at(finger));
  return tips;
}

std::array<TrueFinger, kFingerCount> fingers(const json& j) {
  const auto abduction_deg = matrix<kFingerCount, 1>(j.at("abduction_deg"));
  const auto flexion_deg = matrix<kFingerCount, 1>(j.at("flexion_mcp_deg"));
  std::array<TrueFinger, kFingerCount> f;
  for (int finger = 0; finger < kFingerCount; ++finger)
    f[std::size_t(finger)] = {abduction_deg[finger], flexion_deg[finger]};
  return f;
}

TruthFrame frame(const json& j) {
  TruthFrame f;
  f.T_camera_world = transform(j, "world_to_cam");
  f.T_camera_hand = transform(j, "hand_to_cam");
  // The file keeps one frame for both faces; handyar's has +z towards the camera.
  f.other_face = f.T_camera_hand.linear().col(2).dot(f.T_camera_hand.translation()) > 0;
  if (f.other_face) f.T_camera_hand.linear() *= Eigen::Vector3d(-1, 1, -1).asDiagonal();
  const double fold = j.value("fold", 0.0);
  f.tips_px = tips_px(j);
  f.all_tips_visible = fold < kOutstretchedFold;
  for (int finger = 0; finger < kFingerCount; ++finger)
    f.all_tips_visible &= j.at("tip_visible").at(finger).get<bool>();
  f.layout = layout_in_picture(f.tips_px);
  f.no_open_hand = fold > kFoldedFold || j.value("hand_visible_fraction", 1.0) < kAbsentFraction;
  if (j.contains("other_hand")) f.other_tips_px = tips_px(j["other_hand"]);
  if (j.contains("finger_delta")) f.fingers = fingers(j["finger_delta"]);
  return f;
}

Truth parse(const json& j) {
  Truth t;
  t.camera = camera(j);
  t.hand = hand(j);
  t.frames_per_second = j.value("fps", 30.0);
  if (!(t.frames_per_second > 0)) throw std::runtime_error("fps is not positive");
  t.hand_still_in_world = j.value("static_hand", false);
  if (j.contains("board") && !j["board"].is_null()) {
    const json& b = j["board"];
    t.board = board(b);
    t.T_world_board = transform(b, "board_to_world");
  }
  for (const json& m : j.value("markers", json::array())) {
    t.markers.push_back(marker(m));
    t.T_world_marker.push_back(transform(m, "marker_to_world"));
  }
  for (const json& f : j.at("frames")) {
    if (f.at("frame").get<std::size_t>() != t.frames.size())
      throw std::runtime_error("frame " + std::to_string(t.frames.size()) + " is missing");
    t.frames.push_back(frame(f));
  }
  if (t.frames.empty()) throw std::runtime_error("it has no frames");
  return t;
}

}  // namespace

double TruthFrame::tilt_rad() const {
  const double c = -T_camera_hand.linear().col(2).dot(T_camera_hand.translation().normalized());
  return std::acos(std::clamp(c, -1.0, 1.0));
}

Truth read_truth(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) throw io::Error(file.string(), "cannot be read");
  const std::string fault = "not a sequence's truth: ";
  try {
    return parse(json::parse(in));
  } catch (const json::exception& e) {
    throw io::Error(file.string(), fault + io::fault_of(e));
  } catch (const std::exception& e) {
    throw io::Error(file.string(), fault + e.what());
  }
}

}  // namespace handyar::evaluation
