// SPDX-License-Identifier: MIT
#include "handyar/evaluation/stills.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <opencv2/imgproc.hpp>
#include <set>

#include "annotated_list.hpp"
#include "handyar/io/error.hpp"
#include "handyar/io/pending_file.hpp"
#include "handyar/io/picture_file.hpp"

namespace handyar::evaluation {
namespace {

namespace fs = std::filesystem;

constexpr int kWidth_px = 640, kHeight_px = 480, kFrames = 25;
constexpr double kFramesPerSecond = 30;
constexpr double kNoiseSigma = 2.3;  ///< grey levels: a good camera indoors

Still read_still(const AnnotatedList& list, const AnnotatedList::Row& row) {
  Still s;
  s.file = list.field(row, "file");
  s.picture = (fs::path(list.file()).parent_path() / s.file).string();
  std::error_code ignored;
  if (!fs::is_regular_file(s.picture, ignored))
    throw io::Error(s.picture, "there is no such picture; " + list.file() + ", line " +
                                   std::to_string(row.line) + ", names it");
  if (const auto tone = row.fields.find("skin_tone"); tone != row.fields.end())
    s.skin_tone = tone->second;
  s.tips_px = list.tips_px(row);
  return s;
}

/// The picture in the middle of a black frame, and where its pixels went.
struct Letterbox {
  cv::Mat frame;
  double scale_x, scale_y;
  int left_px, top_px;
};

Letterbox letterbox(const Still& still) {
  // In the pixels as stored, whatever turn the file notes: the annotations are in these.
  const cv::Mat picture = io::read_picture(still.picture, {.upright = false});
  const double s = std::min(double(kWidth_px) / picture.cols, double(kHeight_px) / picture.rows);
  const int width = int(picture.cols * s) / 2 * 2, height = int(picture.rows * s) / 2 * 2;
  if (width == 0 || height == 0)
    throw io::Error(still.picture, std::to_string(picture.cols) + "x" +
                                       std::to_string(picture.rows) + " pixels: too narrow");
  Letterbox box{cv::Mat::zeros(kHeight_px, kWidth_px, CV_8UC3), double(width) / picture.cols,
                double(height) / picture.rows, (kWidth_px - width) / 2, (kHeight_px - height) / 2};
  const cv::Rect inside(box.left_px, box.top_px, width, height);
  cv::resize(picture, box.frame(inside), inside.size(), 0, 0, cv::INTER_AREA);
  return box;
}

/// The last five tips that the tracker gives on the held picture.
std::optional<std::array<Tip, kFingerCount>> hold_and_track(const cv::Mat& still,
                                                            const Config& config, cv::RNG& random) {
  HandTracker tracker(Camera::from_field_of_view(kWidth_px, kHeight_px), average_adult_hand(),
                      config);
  std::optional<std::array<Tip, kFingerCount>> found;
  cv::Mat noise(still.size(), CV_16SC3), frame;
  for (int i = 0; i < kFrames; ++i) {
    random.fill(noise, cv::RNG::NORMAL, 0, kNoiseSigma);
    cv::add(still, noise, frame, cv::noArray(), CV_8U);
    const ImageView view{frame.data, frame.cols, frame.rows, std::ptrdiff_t(frame.step[0]),
                         PixelFormat::bgr};
    const TrackResult r = tracker.process(view, i / kFramesPerSecond);
    if (r.state != State::acquiring && r.state != State::tracking) continue;
    if (std::all_of(r.tips.begin(), r.tips.end(), [](const Tip& t) { return t.known(); }))
      found = r.tips;
  }
  return found;
}

StillResult judge(const Still& still, const Config& config, std::uint64_t seed) {
  StillResult result;
  result.outcome = StillResult::Outcome::not_found;
  result.file = still.file;
  result.source = still.file.substr(0, still.file.find('_'));
  result.skin_tone = still.skin_tone;

  const Letterbox box = letterbox(still);
  TipsPx truth_px;
  for (std::size_t i = 0; i < truth_px.size(); ++i)
    truth_px[i] = {(still.tips_px[i].x() + 0.5) * box.scale_x - 0.5 + box.left_px,
                   (still.tips_px[i].y() + 0.5) * box.scale_y - 0.5 + box.top_px};
  cv::RNG random(seed);
  const auto tips = hold_and_track(box.frame, config, random);
  if (!tips) return result;
  const TipErrors errors = tip_errors(*tips, truth_px);
  for (const double px : errors.px) result.of_span.push_back(px / errors.span_px);
  result.largest_of_span = *std::max_element(result.of_span.begin(), result.of_span.end());
  result.outcome = errors.right() ? StillResult::Outcome::right : StillResult::Outcome::wrong;
  return result;
}

void add_row(Table& t, const std::string& row, const std::vector<StillResult>& results,
             auto&& wanted) {
  int n = 0, right = 0, wrong = 0;
  std::vector<double> of_span;
  for (const StillResult& r : results) {
    if (!wanted(r)) continue;
    ++n;
    wrong += r.outcome == StillResult::Outcome::wrong;
    if (r.outcome != StillResult::Outcome::right) continue;
    ++right;
    of_span.insert(of_span.end(), r.of_span.begin(), r.of_span.end());
  }
  const Summary s = summarize(of_span);
  t.add(row, "stills", n);
  t.add(row, "right", right);
  t.add(row, "wrong", wrong);
  t.add(row, "not found", n - right - wrong);
  t.add(row, "right, share", n ? 100.0 * right / n : kUnknown, "%");
  t.add(row, "error of span, median", s.median);
  t.add(row, "error of span, mean", s.mean);
  t.add(row, "error of span, 95 %", s.p95);
}

const char* words(StillResult::Outcome outcome) {
  switch (outcome) {
    case StillResult::Outcome::right:
      return "right";
    case StillResult::Outcome::wrong:
      return "wrong";
    case StillResult::Outcome::not_found:
      return "not found";
  }
  return "";
}

}  // namespace

std::vector<Still> read_stills(const std::string& list) {
  const AnnotatedList pictures(list);
  std::vector<Still> stills;
  for (const AnnotatedList::Row& row : pictures.rows()) stills.push_back(read_still(pictures, row));
  return stills;
}

std::vector<StillResult> track_stills(const std::vector<Still>& stills, const Progress& progress) {
  const Config config;
  std::vector<StillResult> results;
  for (std::size_t i = 0; i < stills.size(); ++i) {
    results.push_back(judge(stills[i], config, i + 1));
    if (progress) progress(int(i) + 1, int(stills.size()));
  }
  return results;
}

Table stills_table(const std::vector<StillResult>& results) {
  Table t{"stills",
          "stills",
          "Still pictures of five spread fingers",
          "Each letterboxed to 640x480 and held for 25 frames with slight noise. Right: all five "
          "tips within 0.2 of the thumb-little span; error: over that span, of the right ones.",
          {}};
  add_row(t, "all", results, [](const StillResult&) { return true; });
  std::set<std::string> sources, tones;
  for (const StillResult& r : results) {
    sources.insert(r.source);
    if (!r.skin_tone.empty()) tones.insert(r.skin_tone);
  }
  for (const std::string& source : sources)
    add_row(t, source, results, [&](const StillResult& r) { return r.source == source; });
  for (const std::string& tone : tones)
    add_row(t, "skin tone " + tone, results, [&](const auto& r) { return r.skin_tone == tone; });
  if (tones.empty()) t.caption += " The list does not say which skin tone a hand has.";
  return t;
}

void write_stills_csv(const std::string& file, const std::vector<StillResult>& results) {
  std::string text = "file,source,skin_tone,outcome,largest_of_span\n";
  for (const StillResult& r : results)
    text += csv_field(r.file) + "," + csv_field(r.source) + "," + csv_field(r.skin_tone) + "," +
            words(r.outcome) + "," + csv_number(r.largest_of_span) + "\n";
  io::write_text(file, text);
}

}  // namespace handyar::evaluation
