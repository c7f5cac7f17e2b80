// SPDX-License-Identifier: MIT
// handyar._core: what `import handyar` gives. Needs Eigen and numpy, no OpenCV.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <span>
#include <vector>

#include "arrays.hpp"
#include "frame.hpp"
#include "handyar/attachment.hpp"
#include "handyar/planar_pose.hpp"
#include "handyar/pose_filter.hpp"
#include "tracker.hpp"

namespace handyar::python {
namespace {

using namespace pybind11::literals;

template <class... Values>
std::string formatted(const char* format, Values... values) {
  char text[200];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

// None and names: how Python says what C++ says by optional enumerations.
template <class Enum>
py::object name_or_none(const std::optional<Enum>& value) {
  return value ? py::object(py::str(name(*value).data())) : py::none();
}

void require_size(int width_px, int height_px) {
  if (width_px < 1 || height_px < 1)
    throw py::value_error("width_px, height_px: the size of a picture is wanted");
}

void bind_camera(py::module_& m) {
  py::class_<Camera>(m, "Camera", R"(A pinhole camera with distortion, in OpenCV's convention.

Camera frame: x right, y down, z forward, in metres. Pixels: the centre of the top-left pixel is
(0, 0). Distortion: k1, k2, p1, p2, k3 (Brown-Conrady).)")
      .def(py::init([](int width_px, int height_px, double fx_px, double fy_px, double cx_px,
                       double cy_px, const std::array<double, 5>& distortion, double readout_s) {
             require_size(width_px, height_px);
             const auto finite = [](double x) { return std::isfinite(x); };
             if (!(fx_px > 0 && fy_px > 0 && finite(fx_px) && finite(fy_px)))
               throw py::value_error("fx_px, fy_px: focal lengths are positive");
             if (!finite(cx_px) || !finite(cy_px) || !std::ranges::all_of(distortion, finite))
               throw py::value_error("cx_px, cy_px, distortion: finite numbers are wanted");
             if (!(readout_s >= 0 && readout_s <= 0.1))  // as of a camera file
               throw py::value_error("readout_s: seconds from the first row to the last, 0 to 0.1");
             return Camera{width_px, height_px, fx_px, fy_px, cx_px, cy_px, distortion, readout_s};
           }),
           "width_px"_a, "height_px"_a, py::kw_only(), "fx_px"_a, "fy_px"_a, "cx_px"_a, "cy_px"_a,
           "distortion"_a = std::array<double, 5>{}, "readout_s"_a = 0.0,
           "A calibrated camera: picture size, focal lengths and principal point in pixels, "
           "distortion as five numbers k1, k2, p1, p2, k3; for a rolling shutter the seconds from "
           "the first row to the last.")
      .def_static(
          "from_field_of_view",
          [](int width_px, int height_px, double fov_rad) {
            require_size(width_px, height_px);
            if (!(fov_rad > 0 && fov_rad < std::numbers::pi))
              throw py::value_error("fov_rad: an angle between 0 and pi is wanted");
            return Camera::from_field_of_view(width_px, height_px, fov_rad);
          },
          "width_px"_a, "height_px"_a, "fov_rad"_a = std::numbers::pi / 3,
          "A camera without distortion that sees `fov_rad` (radians) across the longer side "
          "of the picture, for when nothing is known; `assumed` is then true.")
      .def_readonly("width_px", &Camera::width_px, "Width of its pictures.")
      .def_readonly("height_px", &Camera::height_px, "Height of its pictures.")
      .def_readonly("assumed", &Camera::assumed,
                    "Whether a field of view was taken for granted: lengths are then of an assumed "
                    "scale.")
      .def_property_readonly(
          "matrix",
          [](const Camera& c) {
            Eigen::Matrix3d K;
            K << c.fx_px, 0, c.cx_px, 0, c.fy_px, c.cy_px, 0, 0, 1;
            return array(K);
          },
          "The camera matrix, shape (3, 3): fx 0 cx; 0 fy cy; 0 0 1, in pixels, as OpenCV has it.")
      .def_property_readonly(
          "distortion",
          [](const Camera& c) {
            return array(Eigen::Map<const Eigen::Matrix<double, 5, 1>>(c.distortion.data()));
          },
          "k1, k2, p1, p2, k3, shape (5,), as OpenCV has them.")
      .def_readonly("readout_s", &Camera::readout_s,
                    "Rolling shutter: seconds from the first row to the last; 0: all at once.")
      .def(
          "scaled_to",
          [](const Camera& c, int width_px, int height_px) {
            require_size(width_px, height_px);
            return c.scaled_to(width_px, height_px);
          },
          "width_px"_a, "height_px"_a,
          "The same camera read out at another size of the same aspect (nothing cropped); an "
          "assumed one: of any aspect.")
      .def(
          "project",
          [](const Camera& c, const Numbers& p_camera) {
            return each<3, 2>(p_camera, "p_camera",
                              [&](const Eigen::Vector3d& p) { return c.project(p); });
          },
          "p_camera"_a,
          "Pixels, shape (..., 2), of points in the camera frame, shape (..., 3), metres, z > 0.")
      .def(
          "unproject",
          [](const Camera& c, const Numbers& px) {
            return each<2, 2>(px, "px", [&](const Eigen::Vector2d& p) { return c.unproject(p); });
          },
          "px"_a,
          "x/z and y/z, shape (..., 2), of the rays through pixels, shape (..., 2); distortion "
          "removed.")
      .def("__repr__", [](const Camera& c) {
        return formatted("<handyar.Camera %dx%d, focal length %.1f px%s>", c.width_px, c.height_px,
                         c.fx_px, c.assumed ? " (assumed)" : "");
      });
}

std::string_view name_of(HandSource source) {  // as in hand files
  switch (source) {
    case HandSource::checkerboard:
      return "checkerboard";
    case HandSource::average_adult:
      return "default";
    case HandSource::self:
      return "self";
    case HandSource::truth:
      return "truth";
  }
  return "";
}

void bind_hand(py::module_& m) {
  py::tuple fingers(kFingerCount);
  for (int i = 0; i < kFingerCount; ++i) fingers[i] = kFingerNames[i];
  m.attr("FINGERS") = fingers;
  py::class_<HandModel>(m, "HandModel", R"(A person's hand, in the hand frame, in metres.

Hand frame: +y along the middle finger towards its tip, +z out of the visible face towards the
camera, +x completes a right-handed frame; the origin lies below the middle finger, level with the
tip of the thumb. From average_adult_hand(), a file (handyar.io.read_hand) or a calibration.)")
      .def_property_readonly(
          "tips_m", [](const HandModel& h) { return points(h.tips_m); },
          "Fingertips, shape (5, 3), metres, in the order of FINGERS.")
      .def_property_readonly(
          "tips_sigma_m", [](const HandModel& h) { return points(h.tips_sigma_m); },
          "Standard deviations of `tips_m`, shape (5, 3), metres; 0: unknown.")
      .def_property_readonly(
          "layout", [](const HandModel& h) { return name(h.layout); },
          "In which `tips_m` was measured: 'thumb_right' or 'thumb_left'.")
      .def_property_readonly(
          "source", [](const HandModel& h) { return name_of(h.source); },
          "Where it comes from: 'checkerboard', 'default' (average adult), 'self' or 'truth'.")
      .def_readonly("rms_px", &HandModel::rms_px, "Reprojection error of the measurement, pixels.")
      .def_property_readonly("scale_assumed", &HandModel::scale_assumed,
                             "Whether the size is an average adult's rather than this hand's.")
      .def_property_readonly("span_m", &HandModel::span_m,
                             "Distance from thumb tip to little fingertip, metres.")
      .def_property_readonly(
          "palm_centre_m", [](const HandModel& h) { return array(h.palm_centre_m()); },
          "Where an object stands: the middle of the palm or of the back of the hand, shape (3,), "
          "metres, in the hand frame.")
      .def(
          "for_layout",
          [](const HandModel& h, const std::string& layout) {
            for (const Layout known : {Layout::thumb_right, Layout::thumb_left})
              if (layout == name(known)) return h.for_layout(known);
            throw py::value_error("layout: 'thumb_right' or 'thumb_left' is wanted, not '" +
                                  layout + "'");
          },
          "layout"_a, "The same hand seen in a layout: x is mirrored where it differs.")
      .def("__repr__", [](const HandModel& h) {
        return formatted("<handyar.HandModel '%s', %.0f mm from thumb to little finger%s>",
                         name_of(h.source).data(), 1000 * h.span_m(),
                         h.scale_assumed() ? " (assumed)" : "");
      });
  m.def(
      "average_adult_hand", &average_adult_hand,
      "The average adult's hand, for when nothing is known: the pose has then the right shape and "
      "an assumed scale.");
}

template <class Pose>
std::string place(const Pose& pose) {
  return formatted("%.3f m away", pose.T_camera_hand.translation().norm());
}

void bind_filter(py::module_& m) {
  py::class_<FilteredPose>(m, "FilteredPose", "A pose with its velocities, at a stated time.")
      .def_readonly("time_s", &FilteredPose::time_s, "Its time, seconds.")
      .def_property_readonly(
          "pose", [](const FilteredPose& p) { return array(p.T_camera_hand); },
          "T_camera_hand, shape (4, 4): takes points of the hand frame to the camera frame, "
          "metres.")
      .def_property_readonly(
          "covariance", [](const FilteredPose& p) { return array(p.covariance); },
          "Of the pose, shape (6, 6): rotation (radians, about the camera's axes), translation "
          "(metres).")
      .def_property_readonly(
          "velocity_m_s", [](const FilteredPose& p) { return array(p.velocity_m_s); },
          "Shape (3,), metres per second, in the camera frame.")
      .def_property_readonly(
          "angular_velocity_rad_s",
          [](const FilteredPose& p) { return array(p.angular_velocity_rad_s); },
          "Shape (3,), radians per second, about the camera's axes.")
      .def("__repr__", [](const FilteredPose& p) {
        return formatted("<handyar.FilteredPose at %.3f s, %s>", p.time_s, place(p).c_str());
      });

  const PoseFilterConfig defaults;
  py::class_<PoseFilterConfig>(m, "PoseFilterConfig",
                               "How a pose is smoothed: how hard the hand is expected to speed up.")
      .def(py::init([](double acceleration_m_s2, double acceleration_rad_s2,
                       double gate_probability, double max_coast_s, bool enabled) {
             if (!std::isfinite(acceleration_m_s2) || !std::isfinite(acceleration_rad_s2) ||
                 std::isnan(gate_probability) || std::isnan(max_coast_s))
               throw py::value_error("the accelerations are finite, and all are numbers");
             return PoseFilterConfig{acceleration_m_s2, acceleration_rad_s2, gate_probability,
                                     max_coast_s, enabled};
           }),
           py::kw_only(), "acceleration_m_s2"_a = defaults.acceleration_m_s2,
           "acceleration_rad_s2"_a = defaults.acceleration_rad_s2,
           "gate_probability"_a = defaults.gate_probability, "max_coast_s"_a = defaults.max_coast_s,
           "enabled"_a = defaults.enabled)
      .def_readonly("acceleration_m_s2", &PoseFilterConfig::acceleration_m_s2,
                    "How hard a hand is expected to speed up, m/s^2; lower: smoother.")
      .def_readonly("acceleration_rad_s2", &PoseFilterConfig::acceleration_rad_s2,
                    "The same for turning, rad/s^2.")
      .def_readonly("gate_probability", &PoseFilterConfig::gate_probability,
                    "Starts anew from a measurement less likely than 1 minus this.")
      .def_readonly("max_coast_s", &PoseFilterConfig::max_coast_s,
                    "Without measurements for longer, seconds: no prediction.")
      .def_readonly("enabled", &PoseFilterConfig::enabled,
                    "False: the raw pose passes through unfiltered.");

  py::class_<PoseFilter>(m, "PoseFilter", R"(Kalman filter on position, orientation and velocities.

It holds still when the hand does and does not lag when it moves. Works for poses from anywhere.)")
      .def(py::init<const PoseFilterConfig&>(), "config"_a = defaults)
      .def(
          "update",
          [](PoseFilter& filter, double time_s, const Numbers& pose, const Numbers& covariance) {
            PoseEstimate measurement;
            measurement.T_camera_hand = isometry_of(pose, "pose");
            measurement.covariance = matrix_of<Matrix6d>(covariance, "covariance");
            measurement.noise_covariance = measurement.covariance;
            return filter.update(time_s, measurement);
          },
          "time_s"_a, "pose"_a, "covariance"_a,
          R"(Takes a pose, shape (4, 4), metres, measured at `time_s` (seconds, after the previous one).

covariance: shape (6, 6), rotation (radians, about the camera's axes), translation (metres).
Starts anew from it where no hand moves so that it would come there. False when a value is not finite
or time does not increase.)")
      .def("predict", &PoseFilter::predict, "time_s"_a,
           "The pose carried to `time_s` (seconds); None before the first measurement and when the "
           "last accepted one is too long ago.")
      .def("reset", &PoseFilter::reset, "Forgets everything.");
}

std::vector<Eigen::Vector2d> points_of(const Numbers& numbers, const char* name) {
  if (numbers.ndim() != 2 || numbers.shape(1) != 2)
    throw py::value_error(std::string(name) + ": an array of shape (n, 2) is wanted");
  std::vector<Eigen::Vector2d> result;
  for (py::ssize_t i = 0; i < numbers.shape(0); ++i)
    result.emplace_back(numbers.at(i, 0), numbers.at(i, 1));
  return result;
}

void bind_planar(py::module_& m) {
  py::class_<PlanarPose>(m, "PlanarPose", "A pose of a plane z = 0 and how well it fits.")
      .def_property_readonly(
          "pose", [](const PlanarPose& p) { return array(p.T_camera_plane); },
          "T_camera_plane, shape (4, 4): takes points of the plane's frame to the camera frame.")
      .def_readonly("rms", &PlanarPose::rms,
                    "Reprojection error per point, in normalised image coordinates.");
  m.def(
      "solve_planar",
      [](const Numbers& plane_m, const Numbers& normalised) {
        const auto on_plane = points_of(plane_m, "plane_m");
        const auto in_picture = points_of(normalised, "normalised");
        if (on_plane.size() != in_picture.size())
          throw py::value_error("plane_m, normalised: one image of each point is wanted");
        std::optional<std::pair<PlanarPose, PlanarPose>> poses;
        if (const auto found = solve_planar(on_plane, in_picture))
          poses.emplace((*found)[0], (*found)[1]);
        return poses;
      },
      "plane_m"_a, "normalised"_a,
      R"(Both poses in which points of a plane look (nearly) the same, the better one first.

plane_m: points of the plane, shape (n, 2), metres, n >= 4. normalised: their images at depth 1, as
Camera.unproject gives them, shape (n, 2). None when they do not tell a pose.)");
}

// One of the fingers' numbers for all fingers, while there is a pose.
template <double FingerState::*kNumber>
py::object of_fingers(const TrackResult& result) {
  if (!result.raw_pose) return py::none();
  Eigen::Matrix<double, kFingerCount, 1> values;
  for (int i = 0; i < kFingerCount; ++i) values[i] = result.fingers[i].*kNumber;
  return array(values);
}

template <std::size_t kCount>
py::array_t<double> places(const std::array<Tip, kCount>& tips) {
  Eigen::Matrix<double, 2, static_cast<int>(kCount)> px;
  px.setConstant(std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < kCount; ++i)
    if (tips[i].known()) px.col(static_cast<int>(i)) = tips[i].px;
  return points(px);
}

template <std::size_t kCount>
py::array_t<bool> seen(const std::array<Tip, kCount>& tips) {
  py::array_t<bool> result(kCount);
  std::transform(tips.begin(), tips.end(), result.mutable_data(),
                 [](const Tip& tip) { return tip.seen; });
  return result;
}

std::string describe(const TrackResult& r) {
  std::string text =
      formatted("<handyar.TrackResult at %.3f s, %s", r.time_s, name(r.state).data());
  if (r.doubtful) text += " (doubtful)";
  if (r.layout) text += ", " + std::string(name(*r.layout));
  if (r.face) text += ", " + std::string(name(*r.face));
  if (r.gesture != Gesture::open) text += ", " + std::string(name(r.gesture));
  if (r.pose) text += ", " + place(*r.pose);
  return text + ">";
}

void bind_result(py::module_& m) {
  const auto covariance = [](const auto& pose) -> const Matrix6d& { return pose.covariance; };
  const auto transform = [](const auto& pose) -> const auto& { return pose.T_camera_hand; };
  py::class_<TrackResult>(m, "TrackResult", "Everything known of the hand in one frame.")
      .def_readonly("time_s", &TrackResult::time_s, "The frame's time, seconds.")
      .def_property_readonly(
          "state", [](const TrackResult& r) { return name(r.state); },
          "'searching' (no hand), 'acquiring' (fingertips seen, not yet confirmed), 'tracking', or "
          "'lost' (was tracking, trying to recover).")
      .def_readonly("doubtful", &TrackResult::doubtful,
                    "Tracking, but the pose is not to be relied on: let an object hold still or "
                    "fade.")
      .def_property_readonly(
          "layout", [](const TrackResult& r) { return name_or_none(r.layout); },
          "Where the thumb is with the fingers up: 'thumb_right' or 'thumb_left'; None without a "
          "hand.")
      .def_property_readonly(
          "face", [](const TrackResult& r) { return name_or_none(r.face); },
          "Which face is seen, 'palm' or 'back', as far as it is told; else None.")
      .def_property_readonly(
          "tips", [](const TrackResult& r) { return places(r.tips); },
          "Fingertips, shape (5, 2), pixels of the frame, in the order of FINGERS; nan where "
          "nothing is known.")
      .def_property_readonly(
          "tips_seen", [](const TrackResult& r) { return seen(r.tips); },
          "Which of `tips` are seen, shape (5,), bool; the others lie outside the frame, where the "
          "rest of the hand puts them, or are nan.")
      .def_property_readonly(
          "webs", [](const TrackResult& r) { return places(r.webs); },
          "Webs between neighbouring fingers, shape (4, 2), pixels; nan where nothing is known.")
      .def_property_readonly(
          "webs_seen", [](const TrackResult& r) { return seen(r.webs); },
          "As `tips_seen`, shape (4,).")
      .def_property_readonly(
          "pose", [=](const TrackResult& r) { return or_none(r.pose, transform); },
          R"(T_camera_hand, filtered, shape (4, 4); None without a hand.

It takes points of the hand frame to the camera frame, in metres: p_camera = pose[:3, :3] @ p_hand +
pose[:3, 3].)")
      .def_property_readonly(
          "covariance", [=](const TrackResult& r) { return or_none(r.pose, covariance); },
          R"(Of `pose`, shape (6, 6): rotation (radians, about the camera's axes), translation (metres).

None without a hand.)")
      .def_property_readonly(
          "velocity_m_s",
          [](const TrackResult& r) {
            return or_none(r.pose, [](const auto& p) { return p.velocity_m_s; });
          },
          "Of the hand frame's origin, shape (3,), metres per second in the camera frame; None "
          "without a hand.")
      .def_property_readonly(
          "angular_velocity_rad_s",
          [](const TrackResult& r) {
            return or_none(r.pose, [](const auto& p) { return p.angular_velocity_rad_s; });
          },
          "Shape (3,), radians per second about the camera's axes; None without a hand.")
      .def_property_readonly(
          "sigma_rotation_rad",
          [](const TrackResult& r) {
            return r.pose ? std::optional(sigma_rotation_rad(r.pose->covariance)) : std::nullopt;
          },
          "Standard deviation of the pose's rotation, radians, root mean square over the axes.")
      .def_property_readonly(
          "sigma_translation_m",
          [](const TrackResult& r) {
            return r.pose ? std::optional(sigma_translation_m(r.pose->covariance)) : std::nullopt;
          },
          "The same of its translation, metres.")
      .def_property_readonly(
          "raw_pose", [=](const TrackResult& r) { return or_none(r.raw_pose, transform); },
          "T_camera_hand from this frame alone, before the filter, shape (4, 4), metres, or None.")
      .def_property_readonly(
          "raw_covariance", [=](const TrackResult& r) { return or_none(r.raw_pose, covariance); },
          "Of `raw_pose`, shape (6, 6), as `covariance`.")
      .def_property_readonly(
          "rms_px",
          [](const TrackResult& r) {
            return r.raw_pose ? std::optional(r.raw_pose->rms_px) : std::nullopt;
          },
          "Distance between the hand in this pose and what was seen, root mean square, pixels.")
      .def_property_readonly("abduction_rad", &of_fingers<&FingerState::abduction_rad>,
                             "How far each finger is turned in the palm plane towards the thumb, "
                             "shape (5,), radians from rest; None without a hand.")
      .def_property_readonly("abduction_sigma_rad", &of_fingers<&FingerState::abduction_sigma_rad>,
                             "Standard deviations of `abduction_rad`, shape (5,).")
      .def_property_readonly(
          "flexion_rad", &of_fingers<&FingerState::flexion_rad>,
          "How far each finger is bent towards the palm, shape (5,), radians from "
          "rest; None without a hand.")
      .def_property_readonly("flexion_sigma_rad", &of_fingers<&FingerState::flexion_sigma_rad>,
                             "Standard deviations of `flexion_rad`, shape (5,).")
      .def_property_readonly(
          "thumb_bend_rad",
          [](const TrackResult& r) {
            return r.raw_pose ? std::optional(r.thumb_bend_rad) : std::nullopt;
          },
          "How far each of the thumb's two last joints is bent in the palm plane, away from the "
          "fingers, radians from rest; None without a hand.")
      .def_property_readonly(
          "gesture", [](const TrackResult& r) { return name(r.gesture); },
          "What the fingers do, for a tenth of a second at least: 'open' (outstretched, or not "
          "known to do anything else), 'fist' (all closed) or 'four' (the thumb folded into the "
          "palm).")
      .def_property_readonly(
          "gesture_event", [](const TrackResult& r) { return name_or_none(r.gesture_event); },
          "What this frame completed: 'grab' (an open hand has closed), 'release' (it has opened, "
          "or is no longer seen), 'click' (the thumb has been folded in) or None.")
      .def_property_readonly(
          "held_pose", [=](const TrackResult& r) { return or_none(r.held_pose, transform); },
          R"(T_camera_hand of the palm while fingers are folded, shape (4, 4), metres, or None.

There is no `pose` meanwhile; an object stays on the palm by this one, which is less sure.)")
      .def_readonly("scale_assumed", &TrackResult::scale_assumed,
                    "Whether the hand was not measured: lengths are then an average adult's.")
      .def_readonly("camera_assumed", &TrackResult::camera_assumed,
                    "Whether the camera was not calibrated.")
      .def("__repr__", &describe);
}

void bind_attachments(py::module_& m) {
  py::tuple names(kAttachmentCount);
  for (int i = 0; i < kAttachmentCount; ++i) names[i] = name(static_cast<Attachment>(i));
  m.attr("ATTACHMENTS") = names;
  m.def(
      "T_hand_attachment",
      [](const std::string& where, const HandModel& hand, const TrackResult& result) {
        const std::optional<Attachment> known = find_attachment(where);
        if (!known) throw py::value_error("where: no place of the hand is called '" + where + "'");
        return array(T_hand_attachment(*known, hand, result));
      },
      "where"_a, "hand"_a, "result"_a,
      R"(The frame of an object that stands on a place of the hand, shape (4, 4), metres.

It takes points of the object's frame to the hand frame, so that result.pose @ it takes them to the
camera frame, and moves with the finger. The origin is where it touches the hand and +z is up: away
from the hand, for a fingertip along the finger. +x is towards the wrist, for a fingertip out of the
visible face.

where: one of ATTACHMENTS: 'face', the middle of the visible one; 'palm' and 'back', behind the hand
where the other is seen; 'wrist'; 'index_base', where a finger leaves the palm; 'index_tip'.
hand: the tracker's, in the layout that `result` tells.)");
}

std::optional<Side> side_of(const std::optional<std::string>& side) {
  if (!side) return std::nullopt;
  for (const Side known : {Side::left, Side::right})
    if (*side == name(known)) return known;
  throw py::value_error("side: 'left', 'right' or None is wanted, not '" + *side + "'");
}

// The silhouette in pixels of the whole frame.
py::array_t<std::uint8_t> mask(Tracker& tracker) {
  struct Picture {
    std::vector<std::uint8_t> pixels;
    int width, height;
  };
  const Picture picture = tracker.use([](const TrackerState& t) {
    Picture p{{}, t.width_px, t.height_px};
    p.pixels.resize(static_cast<std::size_t>(p.width) * p.height);
    const HandMask hand = t.tracker.mask();
    const int right = std::min(p.width, hand.x0_px + hand.width * hand.step_px);
    const int bottom = std::min(p.height, hand.y0_px + hand.height * hand.step_px);
    for (int y = std::max(0, hand.y0_px); y < bottom; ++y) {
      const std::uint8_t* from = hand.data + (y - hand.y0_px) / hand.step_px * hand.stride_bytes;
      std::uint8_t* to = p.pixels.data() + static_cast<std::ptrdiff_t>(y) * p.width;
      for (int x = std::max(0, hand.x0_px); x < right; ++x)
        to[x] = from[(x - hand.x0_px) / hand.step_px];
    }
    return p;
  });
  return py::array_t<std::uint8_t>({picture.height, picture.width}, picture.pixels.data());
}

void bind_tracker(py::module_& m) {
  py::class_<Tracker>(m, "Tracker", R"(Frame and time in, state and pose out.

    tracker = handyar.Tracker(camera, handyar.average_adult_hand())
    result = tracker.process(frame, time_s)
    if result.pose is not None:
        draw_something_at(result.pose)

The interpreter's lock is released while it works, so trackers run side by side in threads; calls of
one tracker from several threads wait for each other.)")
      .def(
          py::init([](const std::optional<Camera>& given, const std::optional<HandModel>& hand,
                      const std::optional<std::string>& side, double smoothing) {
            Config config;
            config.side = side_of(side);
            if (!std::isfinite(smoothing) || smoothing < 0)
              throw py::value_error("smoothing is not a number of at least 0");
            config.smoothing = smoothing;
            const Camera camera = given.value_or(Camera::from_field_of_view(640, 480));
            return std::make_unique<Tracker>(TrackerState{
                camera, HandTracker(camera, hand.value_or(average_adult_hand()), config)});
          }),
          "camera"_a = py::none(), "hand"_a = py::none(), py::kw_only(), "side"_a = py::none(),
          "smoothing"_a = 1.0,
          R"(The camera that makes the frames, and the hand that will be shown to it. None: a field of
view of 60 degrees, the average adult's hand; lengths are then assumed.

The camera is rescaled to frames of another size. side: 'left' or 'right', where it is known which
hand that is: it tells palm from back. smoothing: 1 as designed; more: smoother, and later when the hand speeds up; 0: the
pose of each frame as it is.)")
      .def(
          "process",
          [](Tracker& tracker, const py::object& frame, double time_s, const std::string& format) {
            const ImageView view = view_of(frame, format);
            const TrackResult result = tracker.use([&](TrackerState& t) {
              const TrackResult r = t.tracker.process(view, time_s);
              if (r.status == FrameStatus::ok)
                t.width_px = view.width_px, t.height_px = view.height_px;
              return r;
            });
            if (result.status != FrameStatus::ok)
              throw py::value_error(handyar::describe(result.status));
            return result;
          },
          "frame"_a, "time_s"_a, "format"_a = "bgr",
          R"(What `frame`, made at `time_s`, shows.

frame: uint8, shape (height, width, 3), or (height, width, 4) with an alpha channel that is not
looked at; 160x120 to 4096x2160 pixels. It is read in place: rows may lie anywhere in memory, the
pixels of a row one after the other. No other thread may write on it meanwhile.
time_s: seconds from any origin, more from frame to frame.
format: the order of the channels: 'bgr' as OpenCV has it, 'rgb', 'bgra' or 'rgba'.

A frame without a hand gives a state, never an old pose. A frame that cannot be processed (grey, too
small, of a time that stands still) is a ValueError, another type a TypeError; the tracker is then
as it was.)")
      .def(
          "predict",
          [](Tracker& tracker, double time_s) {
            return tracker.use([&](const TrackerState& t) { return t.tracker.predict(time_s); });
          },
          "time_s"_a,
          "The pose expected at a later time (seconds), for display; None when not tracking.")
      .def(
          "mask", &mask,
          "The hand in the last frame, uint8, shape (height, width) of the frame: 255 hand, 0 not. "
          "A new array.")
      .def_property_readonly(
          "camera",
          [](Tracker& tracker) {
            return tracker.use([](const TrackerState& t) { return t.camera; });
          },
          "The camera it was made with.")
      .def_property_readonly(
          "hand",
          [](Tracker& tracker) {
            return tracker.use([](const TrackerState& t) { return HandModel(t.tracker.hand()); });
          },
          "The person's hand as far as it was learned, in the layout last tracked.")
      .def(
          "reset",
          [](Tracker& tracker) { tracker.use([](TrackerState& t) { t.tracker.reset(); }); },
          "Forgets hand and colours, as newly made; time may begin again.")
      .def(
          "share_view",
          [](Tracker& first, Tracker& second) {
            if (&first == &second) throw py::value_error("share_view: two trackers are wanted");
            Tracker::use_both(first, second, [](TrackerState& a, TrackerState& b) {
              share_view(a.tracker, b.tracker);
            });
          },
          "second"_a, R"(For two hands: each tracker then leaves the other's hand alone.

They do not change hands when these pass each other. Every frame is for both, this one first, in one
thread. It ends when one of them is deleted.)");
}

}  // namespace
}  // namespace handyar::python

PYBIND11_MODULE(_core, m) {
  using namespace handyar::python;
  m.attr("__name__") = "handyar";  // where people find these classes, and help() shows them
  bind_camera(m);
  bind_hand(m);
  bind_filter(m);
  bind_planar(m);
  bind_result(m);
  bind_attachments(m);
  bind_tracker(m);
  m.attr("__name__") = "handyar._core";
}
