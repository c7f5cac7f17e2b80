// SPDX-License-Identifier: MIT
#include "handyar/evaluation/footage.hpp"

#include <optional>
#include <set>
#include <utility>

#include "annotated_list.hpp"
#include "handyar/evaluation/analysis.hpp"
#include "handyar/evaluation/pictures.hpp"
#include "handyar/io/error.hpp"

namespace handyar::evaluation {
namespace {

namespace fs = std::filesystem;

constexpr const char* kOpenFrames = "open_frames.csv";
constexpr double kFarOff_deg = 25, kFarOffOfDistance = 0.2;

bool is_shown_as_sound(const TrackResult& r) {
  return r.state == State::tracking && r.pose && !r.doubtful;
}

std::string group_of(const fs::path& folder, const fs::path& tree) {
  const fs::path below =
      fs::weakly_canonical(folder).lexically_relative(fs::weakly_canonical(tree));
  return below == "." ? fs::weakly_canonical(tree).filename().string() : below.string();
}

/// The clips that a list of open frames names.
std::vector<Footage> read_clips(const fs::path& list, const std::string& group,
                                const SequenceOptions& options) {
  const AnnotatedList frames(list.string());
  std::map<std::string, Footage> clips;
  std::set<std::pair<std::string, int>> before;
  for (const AnnotatedList::Row& row : frames.rows()) {
    const std::string& name = frames.field(row, "clip");
    auto at = clips.find(name);
    if (at == clips.end())
      at = clips
               .emplace(name, Footage{group, open_sequence(list.parent_path() / name, options),
                                      std::map<int, TipsPx>()})
               .first;
    const int frame = frames.frame(row, "frame");
    if (!before.emplace(name, frame).second)
      frames.fail(row, "frame " + std::to_string(frame) + " of " + name + " was there before");
    if (frames.flag(row, "open")) at->second.open_tips_px->emplace(frame, frames.tips_px(row));
  }
  std::vector<Footage> all;
  for (auto& [name, clip] : clips) all.push_back(std::move(clip));
  return all;
}

/// Counts frame by frame what became of the open ones.
class Counter {
 public:
  explicit Counter(FootageFigures& figures) : figures_(figures) {}

  void add(const TrackResult& r, bool open, bool right, bool on_other_hand) {
    const bool tracked = r.state == State::tracking;
    ++figures_.frames;
    figures_.open_frames += open;
    const bool shown = is_shown_as_sound(r);
    figures_.right += open && tracked && right;
    figures_.right_as_sound += open && shown && right;
    figures_.on_other_hand += open && on_other_hand;
    const bool wrong = open && tracked && !right && !on_other_hand;
    figures_.wrong += wrong;
    figures_.wrong_as_sound += wrong && shown;
    figures_.state_changes += open && previous_ && previous_->state != r.state;
    figures_.shown_changes += open && previous_ && previous_->shown != shown;
    previous_ = open ? std::optional(Frame{r.state, shown}) : std::nullopt;
    count_jump(r, shown);
    (tracked ? tracking_ms_ : searching_ms_).push_back(r.times.total_ms);
  }

  /// What comes next does not follow on what was.
  void begin_anew() {
    previous_.reset();
    sound_at_m_.reset();
  }

  void finish() {
    figures_.tracking_ms = summarize(tracking_ms_).median;
    figures_.searching_ms = summarize(searching_ms_).median;
  }

 private:
  void count_jump(const TrackResult& r, bool shown) {
    if (!shown) {
      sound_at_m_.reset();
      return;
    }
    const Eigen::Vector3d at_m = r.pose->T_camera_hand.translation();
    if (sound_at_m_)
      figures_.jumps += (at_m - *sound_at_m_).norm() > kFarOffOfDistance * sound_at_m_->norm();
    sound_at_m_ = at_m;
  }

  struct Frame {
    State state;
    bool shown;
  };
  FootageFigures& figures_;
  std::optional<Frame> previous_;              // if the hand was open in it
  std::optional<Eigen::Vector3d> sound_at_m_;  // of the frame before
  std::vector<double> tracking_ms_, searching_ms_;
};

void measure_rendered(const Analysis& a, FootageFigures& f) {
  const std::vector<FrameError>& errors = a.main_track().errors;
  Counter counter(f);
  int unsound = 0;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const TrackResult& r = a.recording.main_track().results[i];
    const FrameError& e = errors[i];
    counter.add(r, e.eligible, e.right(), e.on_other_hand);
    unsound += is_shown_as_sound(r) && !e.on_other_hand &&
               (e.no_open_hand || e.filtered.rotation_deg > kFarOff_deg ||
                e.filtered.translation_percent > 100 * kFarOffOfDistance);
  }
  f.unsound = unsound;
  counter.finish();
  const Accuracy all = summarize(errors);
  f.handless_frames = all.no_open_hand;
  f.falsely_tracked = all.falsely_tracked;
  f.rotation_deg = all.rotation_deg;
  f.translation_percent = all.translation_percent;
  f.tip_of_span = all.tip_of_span;
  f.abduction_deg = all.abduction_deg;
  f.flexion_deg = all.flexion_deg;
  f.palm_within_8px = all.palm_within_8px;
  f.nees_within_95 = all.nees_within_95;
}

/// The recording, and those that begin later in its first three fifths, `begins` in all.
std::vector<Recording> begun_anew(const Recording& whole, int begins) {
  constexpr double kFirstPart = 0.6;
  std::vector<Recording> recordings{whole};
  for (int i = 1; i < begins; ++i) {
    const auto at = std::size_t(kFirstPart * i / begins * double(whole.frame_index.size()));
    recordings.push_back(record(whole.sequence, Methods::figure_only, {}, whole.frame_index[at]));
  }
  return recordings;
}

/// Of a clip that is begun as often as it has recordings.
void measure_clip(const std::map<int, TipsPx>& open_tips_px,
                  const std::vector<Recording>& recordings, FootageFigures& f) {
  Counter counter(f);
  std::vector<double> of_span;
  int not_open = 0, tracked = 0;
  for (const Recording& recording : recordings) {
    const std::vector<TrackResult>& results = recording.main_track().results;
    counter.begin_anew();
    InView in_view;
    for (std::size_t i = 0; i < results.size(); ++i) {
      const auto tips = open_tips_px.find(int(recording.frame_index[i]));
      const bool named_open = tips != open_tips_px.end();
      const bool open = in_view.add(named_open, recording.time_s[i]);
      const TipErrors errors = open ? tip_errors(results[i].tips, tips->second) : TipErrors{};
      counter.add(results[i], open, errors.right(), false);
      if (errors.right())
        for (const double px : errors.px) of_span.push_back(px / errors.span_px);
      not_open += !named_open;
      tracked += !named_open && results[i].state == State::tracking;
    }
  }
  counter.finish();
  f.tip_of_span = summarize(of_span);
  if (f.open_frames > 0) return;
  f.handless_frames = not_open;
  f.falsely_tracked = tracked;
}

/// Speed and steadiness are all that can be said of it.
void measure_unknown(const Recording& recording, FootageFigures& f) {
  Counter counter(f);
  for (const TrackResult& r : recording.main_track().results) counter.add(r, false, false, false);
  counter.finish();
}

}  // namespace

std::vector<Footage> find_footage(const fs::path& tree, const SequenceOptions& options) {
  std::set<fs::path> folders{tree};
  for (const fs::directory_entry& e : fs::recursive_directory_iterator(tree))
    if (e.is_directory()) folders.insert(e.path());
  std::vector<Footage> all;
  for (const fs::path& folder : folders) {
    if (fs::exists(folder / kOpenFrames))
      for (Footage& clip : read_clips(folder / kOpenFrames, group_of(folder, tree), options))
        all.push_back(std::move(clip));
    if (fs::exists(folder / "video.mp4"))
      all.push_back({group_of(folder.parent_path(), tree), open_sequence(folder, options), {}});
  }
  if (all.empty())
    throw io::Error(tree.string(), std::string("has no video.mp4 and no ") + kOpenFrames +
                                       ", nor has a folder in it");
  return all;
}

FootageFigures measure(const Footage& footage, int begins) {
  const Analysis a = analyse(record(footage.sequence, Methods::figure_only));
  FootageFigures f;
  f.group = footage.group;
  f.name = footage.sequence.name;
  f.broken_off = a.recording.broken_off;
  if (a.has_truth())
    measure_rendered(a, f);
  else if (footage.open_tips_px)
    measure_clip(*footage.open_tips_px, begun_anew(a.recording, begins), f);
  else
    measure_unknown(a.recording, f);
  for (Picture& p : take_pictures(a)) {
    if (!f.worst_jpeg.empty() && !p.worst) continue;
    f.worst_caption = p.caption;
    f.worst_jpeg = std::move(p.jpeg);
    if (p.worst) break;
  }
  return f;
}

}  // namespace handyar::evaluation
