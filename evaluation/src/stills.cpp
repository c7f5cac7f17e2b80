// SPDX-License-Identifier: MIT
#include "handyar/evaluation/stills.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <set>

#include "handyar/io/error.hpp"
#include "handyar/io/pending_file.hpp"

namespace handyar::evaluation {
namespace {

namespace fs = std::filesystem;

constexpr int kWidth_px = 640, kHeight_px = 480, kFrames = 25;
constexpr double kFramesPerSecond = 30;
constexpr double kNoiseSigma = 2.3;  ///< grey levels: a good camera indoors
constexpr double kRightOfSpan = 0.2;

using Row = std::map<std::string, std::string>;

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (const char c : line) {
    if (c == '"')
      quoted = !quoted;
    else if (c == ',' && !quoted)
      fields.emplace_back();
    else if (c != '\r')
      fields.back() += c;
  }
  return fields;
}

std::vector<Row> read_rows(const std::string& list) {
  std::ifstream in(list);
  std::string line;
  if (!in || !std::getline(in, line)) throw io::Error(list, "cannot be read");
  const std::vector<std::string> header = split(line);
  std::vector<Row> rows;
  while (std::getline(in, line)) {
    if (line.empty()) continue;
    const std::vector<std::string> fields = split(line);
    if (fields.size() != header.size())
      throw io::Error(list, "line " + std::to_string(rows.size() + 2) + " has " +
                                std::to_string(fields.size()) + " fields, the header " +
                                std::to_string(header.size()));
    Row& row = rows.emplace_back();
    for (std::size_t i = 0; i < header.size(); ++i) row[header[i]] = fields[i];
  }
  return rows;
}

double number(const std::string& list, const Row& row, const std::string& column) {
  const auto field = row.find(column);
  if (field == row.end()) throw io::Error(list, "has no column " + column);
  double value = 0;
  const char* end = field->second.data() + field->second.size();
  if (std::from_chars(field->second.data(), end, value).ptr != end || !std::isfinite(value))
    throw io::Error(list, column + " of " + row.at("file") + " is not a number");
  return value;
}

/// The picture in the middle of a black frame, and where its pixels went.
struct Letterbox {
  cv::Mat frame;
  double scale_x, scale_y;
  int left_px, top_px;
};

Letterbox letterbox(const cv::Mat& picture) {
  const double s = std::min(double(kWidth_px) / picture.cols, double(kHeight_px) / picture.rows);
  const int width = int(picture.cols * s) / 2 * 2, height = int(picture.rows * s) / 2 * 2;
  Letterbox box{cv::Mat::zeros(kHeight_px, kWidth_px, CV_8UC3), double(width) / picture.cols,
                double(height) / picture.rows, (kWidth_px - width) / 2, (kHeight_px - height) / 2};
  const cv::Rect inside(box.left_px, box.top_px, width, height);
  cv::resize(picture, box.frame(inside), inside.size(), 0, 0, cv::INTER_AREA);
  return box;
}

using Tips = std::array<Eigen::Vector2d, kFingerCount>;

/// The last five tips that the tracker gives on the held picture.
std::optional<Tips> hold_and_track(const cv::Mat& still, const Config& config, cv::RNG& random) {
  HandTracker tracker(Camera::from_field_of_view(kWidth_px, kHeight_px), average_adult_hand(),
                      config);
  std::optional<Tips> found;
  cv::Mat noise(still.size(), CV_16SC3), frame;
  for (int i = 0; i < kFrames; ++i) {
    random.fill(noise, cv::RNG::NORMAL, 0, kNoiseSigma);
    cv::add(still, noise, frame, cv::noArray(), CV_8U);
    const ImageView view{frame.data, frame.cols, frame.rows, std::ptrdiff_t(frame.step[0]),
                         PixelFormat::bgr};
    const TrackResult r = tracker.process(view, i / kFramesPerSecond);
    if (r.state != State::acquiring && r.state != State::tracking) continue;
    if (!std::all_of(r.tips.begin(), r.tips.end(), [](const Tip& t) { return t.seen; })) continue;
    Tips& tips = found.emplace();
    for (std::size_t k = 0; k < tips.size(); ++k) tips[k] = r.tips[k].px;
  }
  return found;
}

StillResult judge(const std::string& list, const Row& row, const cv::Mat& picture,
                  const Config& config, std::uint64_t seed) {
  StillResult result;
  result.outcome = StillResult::Outcome::not_found;
  result.file = row.at("file");
  result.source = result.file.substr(0, result.file.find('_'));
  if (const auto tone = row.find("skin_tone"); tone != row.end()) result.skin_tone = tone->second;

  const Letterbox box = letterbox(picture);
  Tips truth;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const std::string finger(kFingerNames[i]);
    truth[i] = {number(list, row, finger + "_x") * box.scale_x + box.left_px,
                number(list, row, finger + "_y") * box.scale_y + box.top_px};
  }
  cv::RNG random(seed);
  const std::optional<Tips> tips = hold_and_track(box.frame, config, random);
  if (!tips) return result;
  const double span_px = (truth[0] - truth[4]).norm();
  for (std::size_t i = 0; i < truth.size(); ++i)
    result.of_span.push_back(((*tips)[i] - truth[i]).norm() / span_px);
  result.largest_of_span = *std::max_element(result.of_span.begin(), result.of_span.end());
  result.outcome = result.largest_of_span > kRightOfSpan ? StillResult::Outcome::wrong
                                                         : StillResult::Outcome::right;
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

std::vector<StillResult> track_stills(const std::string& list, const SkinColors& skin,
                                      const Progress& progress) {
  Config config;
  config.skin.personal = skin;
  const fs::path folder = fs::path(list).parent_path();
  const std::vector<Row> rows = read_rows(list);
  std::vector<StillResult> results;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (!rows[i].contains("file")) throw io::Error(list, "has no column file");
    // The annotations are in the pixels as stored, whatever turn the file notes.
    const cv::Mat picture = cv::imread((folder / rows[i].at("file")).string(),
                                       cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
    if (!picture.empty()) results.push_back(judge(list, rows[i], picture, config, i + 1));
    if (progress) progress(int(i) + 1, int(rows.size()));
  }
  if (results.empty()) throw io::Error(list, "none of its pictures can be read");
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
