// SPDX-License-Identifier: MIT
#include "handyar/evaluation/analysis.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "handyar/evaluation/tables.hpp"
#include "handyar/io/pending_file.hpp"

namespace handyar::evaluation {
namespace {

Poses tracked_poses(const std::vector<TrackResult>& results, bool filtered) {
  Poses poses(results.size());
  for (std::size_t i = 0; i < results.size(); ++i) {
    const TrackResult& r = results[i];
    if (r.state != State::tracking) continue;
    if (filtered && r.pose) poses[i] = r.pose->T_camera_hand;
    if (!filtered && r.raw_pose) poses[i] = r.raw_pose->T_camera_hand;
  }
  return poses;
}

TrackAnalysis analyse_track(const Recording& r, const Track& track, bool board_is_of_use) {
  TrackAnalysis a;
  const Sequence& s = r.sequence;
  if (s.truth) {
    a.errors = compare(*s.truth, track.hand, track.results);
    if (s.truth->board && s.truth->hand_still_in_world)
      for (const FrameError& e : a.errors) {
        a.raw.exact_px.push_back(e.counted() ? e.board_raw_px : kUnknown);
        a.filtered.exact_px.push_back(e.counted() ? e.board_filtered_px : kUnknown);
      }
  }
  if (!board_is_of_use) return a;
  const auto by_blocks = [&](bool filtered) {
    return board_errors_px(*s.board, s.camera, r.board_views,
                           tracked_poses(track.results, filtered));
  };
  a.raw.blocks_px = by_blocks(false);
  a.filtered.blocks_px = by_blocks(true);
  return a;
}

BoardErrors analyse_marker(const Recording& r, const MarkerTrack& track) {
  BoardErrors e;
  const Sequence& s = r.sequence;
  e.blocks_px = board_errors_px(*s.board, s.camera, r.board_views, track.T_camera_marker);
  if (!s.truth || !s.truth->T_world_board) return e;
  const bool april = track.system == "AprilTag";
  for (std::size_t m = 0; m < s.truth->markers.size(); ++m) {
    if (s.truth->markers[m].is_apriltag() != april) continue;
    std::vector<Eigen::Isometry3d> T_camera_board;
    for (const TruthFrame& f : s.truth->frames)
      T_camera_board.push_back(f.T_camera_world * *s.truth->T_world_board);
    e.exact_px = board_errors_px(*s.board, s.camera, T_camera_board, track.T_camera_marker,
                                 s.truth->T_world_marker[m].inverse() * *s.truth->T_world_board);
  }
  return e;
}

bool any_marker(const Recording& r, const std::string& system) {
  const MarkerTrack* t = r.find_marker(system, false);
  return t && std::any_of(t->T_camera_marker.begin(), t->T_camera_marker.end(),
                          [](const auto& T) { return T.has_value(); });
}

std::vector<std::string> what_is_unknown(const Analysis& a) {
  const Sequence& s = a.recording.sequence;
  std::vector<std::string> u;
  if (!a.recording.broken_off.empty()) u.push_back(a.recording.broken_off);
  if (!s.truth)
    u.push_back(
        "No truth.json: whether the fingertips and the pose are right, the delay, and the "
        "honesty of the covariance cannot be said.");
  if (s.camera.assumed)
    u.push_back(
        "The camera was not calibrated (its field of view was assumed): lengths and angles are "
        "approximate.");
  if (s.hand.scale_assumed())
    u.push_back(
        "The hand was not measured (an average adult's was assumed): distances have the "
        "right shape and an assumed scale.");
  if (!s.board)
    u.push_back(
        "No checkerboard is known: the paper's reprojection error (Tables 2 and 3, "
        "Figure 8) cannot be measured. Own footage: --board 8x6 --square-mm 25.");
  else if (!a.has_board())
    u.push_back(
        "The checkerboard was not found whole in any frame: the paper's reprojection error "
        "(Tables 2 and 3, Figure 8) cannot be measured.");
  else if (s.truth && !s.truth->hand_still_in_world)
    u.push_back(
        "The hand moves relative to the board: its reprojection error at the board's "
        "corners has no meaning here.");
  else if (summarize(a.main_track().raw.blocks_px).n == 0)
    u.push_back(
        "Hand and board are seen together in too few frames: the paper's reprojection error "
        "(Tables 2 and 3, Figure 8) needs five in one of two blocks of 15 frames to judge those in "
        "the other.");
  else if (!s.truth)
    u.push_back("The hand was taken to lie still beside the board all the time.");
  for (const auto& [system, marker] :
       {std::pair("ArUco", &s.aruco), std::pair("AprilTag", &s.apriltag)})
    if (!any_marker(a.recording, system))
      u.push_back(std::string("No ") + system +
                  " marker was found: of that system only the time it takes is known.");
    else if (a.has_board() && !marker->size_known)
      u.push_back(std::string("The size of the ") + system +
                  " marker is as given or assumed on the command line.");
  return u;
}

}  // namespace

bool Analysis::has_board() const {
  return std::any_of(recording.board_views.begin(), recording.board_views.end(),
                     [](const auto& view) { return view.has_value(); });
}

Analysis analyse(Recording recording) {
  Analysis a;
  a.recording = std::move(recording);
  const Recording& r = a.recording;
  const bool board = a.has_board();
  const bool still = !r.sequence.truth || r.sequence.truth->hand_still_in_world;
  for (const Track& t : r.tracks) a.tracks.push_back(analyse_track(r, t, board && still));
  for (const MarkerTrack& t : r.markers)
    a.markers.push_back(board ? analyse_marker(r, t) : BoardErrors{});
  if (board) a.own_px = own_errors_px(*r.sequence.board, r.sequence.camera, r.board_views);
  a.unknown = what_is_unknown(a);
  return a;
}

const std::vector<double>* ErrorColumns::find(const std::string& wanted) const {
  const auto at = std::find(names.begin(), names.end(), wanted);
  return at == names.end() ? nullptr : &values[std::size_t(at - names.begin())];
}

ErrorColumns error_columns(const Analysis& a) {
  ErrorColumns c;
  const std::vector<TrackResult>& results = a.recording.main_track().results;
  const TrackAnalysis& main = a.main_track();
  const std::size_t n = results.size();
  // Of frames beyond the truth the flags too are unknown, not false.
  const std::size_t judged = a.has_truth() ? a.recording.sequence.truth->frames.size() : 0;
  for (const TrackResult& r : results) c.states.emplace_back(name(r.state));
  const auto add = [&](const std::string& title, auto value_at) {
    c.names.push_back(title);
    std::vector<double>& v = c.values.emplace_back(n);
    for (std::size_t i = 0; i < n; ++i) v[i] = value_at(i);
  };
  const auto add_list = [&](const std::string& title, const std::vector<double>& list) {
    add(title, [&](std::size_t i) { return i < list.size() ? list[i] : kUnknown; });
  };
  const auto add_error = [&](const std::string& title, auto member) {
    add(title, [&](std::size_t i) {
      return i < judged && i < main.errors.size() ? double(member(main.errors[i])) : kUnknown;
    });
  };
  add_list("time_s", a.recording.time_s);
  add_error("eligible", [](const FrameError& e) { return e.eligible; });
  add_error("no_open_hand", [](const FrameError& e) { return e.no_open_hand; });
  add_error("on_other_hand", [](const FrameError& e) { return e.on_other_hand; });
  add_error("wrong", [](const FrameError& e) { return e.wrong; });
  add_list("board_raw_px", main.raw.blocks_px);
  add_list("board_filtered_px", main.filtered.blocks_px);
  for (std::size_t m = 0; m < a.markers.size(); ++m) {
    if (a.recording.markers[m].half_resolution) continue;
    const std::string system = a.recording.markers[m].system == "ArUco" ? "aruco" : "apriltag";
    add_list("board_" + system + "_px", a.markers[m].blocks_px);
    add_list("board_exact_" + system + "_px", a.markers[m].exact_px);
  }
  add_list("board_own_px", a.own_px);
  add_list("board_exact_raw_px", main.raw.exact_px);
  add_list("board_exact_filtered_px", main.filtered.exact_px);
  for (std::size_t f = 0; f < kFingerCount; ++f)
    add_error(std::string(kFingerNames[f]) + "_px",
              [f](const FrameError& e) { return e.tips.px[f]; });
  add_error("span_px", [](const FrameError& e) { return e.tips.span_px; });
  add_error("rotation_raw_deg", [](const FrameError& e) { return e.raw.rotation_deg; });
  add_error("rotation_deg", [](const FrameError& e) { return e.filtered.rotation_deg; });
  add_error("translation_raw_mm", [](const FrameError& e) { return e.raw.translation_mm; });
  add_error("translation_mm", [](const FrameError& e) { return e.filtered.translation_mm; });
  add_error("abduction_deg", [](const FrameError& e) { return e.abduction_deg; });
  add_error("flexion_deg", [](const FrameError& e) { return e.flexion_deg; });
  add_error("nees_raw", [](const FrameError& e) { return e.raw.nees; });
  add_error("nees", [](const FrameError& e) { return e.filtered.nees; });
  add_error("tilt_deg", [](const FrameError& e) { return e.tilt_deg; });
  add_error("distance_mm", [](const FrameError& e) { return e.distance_mm; });
  add("rms_px",
      [&](std::size_t i) { return results[i].raw_pose ? results[i].raw_pose->rms_px : kUnknown; });
  add("total_ms", [&](std::size_t i) { return results[i].times.total_ms; });
  return c;
}

void write_errors_csv(const std::string& file, const std::vector<Analysis>& analyses) {
  std::string text;
  for (const Analysis& a : analyses) {
    const ErrorColumns c = error_columns(a);
    if (text.empty()) {
      text = "sequence,frame,state";
      for (const std::string& title : c.names) text += "," + title;
      text += "\n";
    }
    for (std::size_t i = 0; i < c.states.size(); ++i) {
      text += csv_field(a.recording.sequence.name) + "," +
              std::to_string(a.recording.frame_index[i]) + "," + c.states[i];
      for (const std::vector<double>& v : c.values) text += "," + csv_number(v[i]);
      text += "\n";
    }
  }
  io::write_text(file, text);
}

}  // namespace handyar::evaluation
