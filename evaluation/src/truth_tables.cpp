// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <iterator>

#include "handyar/evaluation/tables.hpp"

namespace handyar::evaluation {
namespace {

void add_summary(Table& t, const std::string& row, const Summary& s, const std::string& unit) {
  t.add(row, "median", s.median, unit);
  t.add(row, "mean", s.mean, unit);
  t.add(row, "95 %", s.p95, unit);
  t.add(row, "n", s.n);
}

/// Recoveries of one kind: how many, how many never ended well, and how long they took.
struct RecoverySummary {
  int count = 0, never = 0;
  Summary after_s;
};

RecoverySummary summarize_recoveries(const std::vector<Recovery>& all, auto&& wanted) {
  RecoverySummary s;
  std::vector<double> after_s;
  for (const Recovery& r : all) {
    if (!wanted(r.kind)) continue;
    ++s.count;
    if (r.after_s)
      after_s.push_back(*r.after_s);
    else
      ++s.never;
  }
  s.after_s = summarize(after_s);
  return s;
}

void add_view_rows(Table& t, const Analysis& a, const std::string& what, double width,
                   double FrameError::*of, const std::string& unit) {
  double most = 0;
  for (const FrameError& e : a.main_track().errors)
    if (e.eligible && std::isfinite(e.*of)) most = std::max(most, e.*of);
  for (double from = 0; from <= most; from += width) {
    std::vector<FrameError> bin;
    std::copy_if(
        a.main_track().errors.begin(), a.main_track().errors.end(), std::back_inserter(bin),
        [&](const FrameError& e) { return e.eligible && e.*of >= from && e.*of < from + width; });
    if (bin.empty()) continue;
    const Accuracy s = summarize(bin);
    const std::string row =
        what + " " + csv_number(from) + " to " + csv_number(from + width) + unit;
    t.add(row, "eligible", s.eligible, "frames");
    t.add(row, "tracked", s.tracked_percent(), "%");
    t.add(row, "fingertips, median", s.tip_px.median, "px");
    t.add(row, "rotation, median", s.rotation_deg.median, "°");
    t.add(row, "translation, median", s.translation_mm.median, "mm");
    t.add(row, "translation of distance, median", s.translation_percent.median, "%");
  }
}

}  // namespace

Table accuracy_table(const Analysis& a) {
  Table t{
      "accuracy",
      a.recording.sequence.name,
      "Accuracy against truth",
      "Over the frames that are eligible (five tips visible for 0.4 s, after 25 frames to begin "
      "with), tracked, and not wrong (no tip off by more than 0.2 of the thumb-little span). Pose: "
      "filtered, and raw from one frame alone. Board: rms at the inner "
      "corners, the hand-to-board transform known exactly. Middle of the palm: where an object "
      "stands, in the image. Consistency: normalised estimation error squared; 6 on average, and "
      "95 % below 12.59, when the stated covariance is honest.",
      {}};
  if (!a.has_truth()) return t;
  const Accuracy s = summarize(a.main_track().errors);
  add_summary(t, "fingertips", s.tip_px, "px");
  for (std::size_t f = 0; f < kFingerCount; ++f)
    add_summary(t, std::string(kFingerNames[f]), s.finger_px[f], "px");
  add_summary(t, "fingertips, of the span", s.tip_of_span, "");
  add_summary(t, "rotation, filtered", s.rotation_deg, "°");
  add_summary(t, "rotation, raw", s.rotation_raw_deg, "°");
  add_summary(t, "translation, filtered", s.translation_mm, "mm");
  add_summary(t, "translation, raw", s.translation_raw_mm, "mm");
  add_summary(t, "translation of distance, filtered", s.translation_percent, "%");
  if (s.board_px.n > 0) {
    add_summary(t, "board, filtered", s.board_px, "px");
    add_summary(t, "board, raw", s.board_raw_px, "px");
  }
  add_summary(t, "middle of the palm, filtered", s.palm_px, "px");
  t.add("middle of the palm, filtered", "within 8 px", 100 * s.palm_within_8px, "%");
  if (s.abduction_deg.n > 0) {
    add_summary(t, "fingers, abduction", s.abduction_deg, "°");
    add_summary(t, "fingers, flexion", s.flexion_deg, "°");
  }
  add_summary(t, "consistency, filtered", s.nees, "");
  t.add("consistency, filtered", "below 12.59", 100 * s.nees_within_95, "%");
  add_summary(t, "consistency, raw", s.nees_raw, "");
  t.add("consistency, raw", "below 12.59", 100 * s.nees_raw_within_95, "%");
  return t;
}

Table tracking_table(const Analysis& a) {
  Table t{"tracking",
          a.recording.sequence.name,
          "Tracking",
          "Wrong: of the tracked frames. Other face: back taken for palm or the reverse. Falsely "
          "tracked: while no open hand is in the picture, or less than a twentieth of it.",
          {}};
  if (!a.has_truth()) return t;
  const Accuracy acc = summarize(a.main_track().errors);
  const std::string row = a.recording.sequence.name;
  t.add(row, "frames", acc.frames);
  t.add(row, "eligible", acc.eligible, "frames");
  t.add(row, "tracked", acc.tracked_percent(), "%");
  t.add(row, "wrong", acc.wrong_percent(), "%");
  t.add(row, "other face", acc.layout_wrong, "frames");
  t.add(row, "on the other hand", acc.on_other_hand, "frames");
  t.add(row, "no open hand", acc.no_open_hand, "frames");
  t.add(row, "falsely tracked", acc.falsely_tracked, "frames");
  return t;
}

Table motion_table(const Analysis& a) {
  Table t{
      "motion",
      a.recording.sequence.name,
      "Stillness and delay",
      "Jitter: standard deviation of the pose's error in runs of eight and more frames in which "
      "the hand moves less than 1 mm a frame. Delay: where the displacements of three points of "
      "the hand correlate best with the true ones; unknown where too little moves.",
      {}};
  if (!a.has_truth()) return t;
  const Sequence& s = a.recording.sequence;
  for (const bool filtered : {false, true}) {
    const std::string row = filtered ? "filtered pose" : "raw pose";
    const Poses poses =
        right_poses(*s.truth, a.recording.main_track().hand, a.recording.main_track().results,
                    a.main_track().errors, filtered);
    const Jitter j = jitter(*s.truth, poses);
    t.add(row, "jitter of translation", j.translation_mm, "mm");
    t.add(row, "jitter of rotation", j.rotation_deg, "°");
    t.add(row, "still", j.frames, "frames");
    const std::optional<double> delay = delay_s(*s.truth, poses);
    t.add(row, "delay", delay ? 1e3 * *delay : kUnknown, "ms");
  }
  return t;
}

Table recovery_table(const Analysis& a) {
  Table t{"recovery",
          a.recording.sequence.name,
          "Finding the hand",
          "From the five tips' coming into view, or a loss in plain view, until they are rightly "
          "tracked. Never: hidden again or at the end before that.",
          {}};
  if (!a.has_truth()) return t;
  const std::vector<Recovery> all = recoveries(*a.recording.sequence.truth, a.main_track().errors);
  const std::pair<Recovery::Kind, const char*> kinds[] = {
      {Recovery::Kind::first_sight, "at first sight"},
      {Recovery::Kind::hidden_before, "after tips were hidden"},
      {Recovery::Kind::lost_in_view, "after a loss in plain view"}};
  for (const auto& [kind, row] : kinds) {
    const RecoverySummary s =
        summarize_recoveries(all, [kind = kind](auto k) { return k == kind; });
    t.add(row, "times", s.count);
    t.add(row, "never found", s.never);
    t.add(row, "median", s.after_s.median, "s");
    t.add(row, "longest", s.after_s.max, "s");
  }
  return t;
}

Table view_table(const Analysis& a) {
  Table t{"view",
          a.recording.sequence.name,
          "Error against tilt and distance",
          "Filtered pose. Tilt: between the hand's normal and the line of sight, 0° is face on. "
          "Distance: camera to the hand's origin.",
          {}};
  if (!a.has_truth()) return t;
  add_view_rows(t, a, "tilt", 10, &FrameError::tilt_deg, "°");
  add_view_rows(t, a, "distance", 50, &FrameError::distance_mm, " mm");
  return t;
}

Table robustness_table(const std::vector<Analysis>& analyses) {
  Table t{"robustness",
          "all",
          "Robustness: one row a sequence",
          "Tracked: of the eligible frames (without truth: of all). Wrong: of the tracked. Tip, "
          "rotation and translation: median over the frames that count, filtered pose. Found "
          "again: the longest time until a visible hand is rightly tracked.",
          {}};
  for (const Analysis& a : analyses) {
    const std::string& row = a.recording.sequence.name;
    const auto& results = a.recording.main_track().results;
    const auto tracking = std::count_if(results.begin(), results.end(), [](const TrackResult& r) {
      return r.state == State::tracking;
    });
    const Accuracy s = summarize(a.main_track().errors);
    RecoverySummary found;
    if (a.has_truth())
      found = summarize_recoveries(recoveries(*a.recording.sequence.truth, a.main_track().errors),
                                   [](auto kind) { return kind != Recovery::Kind::first_sight; });
    const double all = double(std::max<std::size_t>(1, results.size()));
    t.add(row, "frames", double(results.size()));
    t.add(row, "eligible", a.has_truth() ? s.eligible : kUnknown);
    t.add(row, "tracked", a.has_truth() ? s.tracked_percent() : 100.0 * double(tracking) / all,
          "%");
    t.add(row, "wrong", s.wrong_percent(), "%");
    t.add(row, "falsely tracked", a.has_truth() ? s.falsely_tracked : kUnknown, "frames");
    t.add(row, "tip", s.tip_px.median, "px");
    t.add(row, "tip of span", 100 * s.tip_of_span.median, "%");
    t.add(row, "rotation", s.rotation_deg.median, "°");
    t.add(row, "translation", s.translation_mm.median, "mm");
    t.add(row, "found again", found.after_s.max, "s");
    t.add(row, "never found again", a.has_truth() ? found.never : kUnknown, "times");
    std::vector<double> ms;
    for (const TrackResult& r : results) ms.push_back(r.times.total_ms);
    t.add(row, "time", summarize(ms).median, "ms");
  }
  return t;
}

}  // namespace handyar::evaluation
