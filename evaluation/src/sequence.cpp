// SPDX-License-Identifier: MIT
#include "handyar/evaluation/sequence.hpp"

#include <algorithm>

#include "handyar/io/camera_file.hpp"
#include "handyar/io/error.hpp"
#include "handyar/io/frame_source.hpp"
#include "handyar/io/hand_file.hpp"
#include "handyar/io/sample.hpp"

namespace handyar::evaluation {
namespace {

namespace fs = std::filesystem;

/// A file of the sequence's folder, if it has a folder and is not told about by truth.json.
std::string companion(const Sequence& s, const fs::path& folder, const char* name) {
  const bool there = !folder.empty() && !s.truth && fs::exists(folder / name);
  return there ? (folder / name).string() : "";
}

void find_camera(Sequence& s, const fs::path& folder, const SequenceOptions& options) {
  const std::string file =
      options.camera_file.empty() ? companion(s, folder, "camera.yml") : options.camera_file;
  const io::SourceInfo info = io::open_input(s.video)->info();
  if (info.live) throw io::Error(s.video, "a live camera cannot be evaluated; record it first");
  if (s.truth &&
      (s.truth->camera.width_px != info.width_px || s.truth->camera.height_px != info.height_px))
    throw io::Error(s.video, "its frames are not of the size that truth.json gives");
  if (!file.empty()) {
    s.camera = io::camera_for_size(io::read_camera(file), info.width_px, info.height_px, file);
    s.origin_of_camera = file;
  } else if (s.truth) {
    s.camera = s.truth->camera;
    s.origin_of_camera = "truth.json";
  } else {
    s.camera = Camera::from_field_of_view(info.width_px, info.height_px);
    s.origin_of_camera = "assumed: 60 degrees across";
  }
}

void find_hand(Sequence& s, const fs::path& folder, const SequenceOptions& options) {
  const std::string file =
      options.hand_file.empty() ? companion(s, folder, "hand.json") : options.hand_file;
  if (options.uncalibrated) {
    s.hand = average_adult_hand();
    s.origin_of_hand = "average adult, as asked";
  } else if (!file.empty()) {
    s.hand = io::read_hand(file);
    s.origin_of_hand = file;
  } else if (s.truth) {
    s.hand = s.truth->hand;
    s.origin_of_hand = "truth.json";
  } else {
    s.hand = average_adult_hand();
    s.origin_of_hand = "assumed: average adult";
  }
}

void find_prints(Sequence& s, const SequenceOptions& options) {
  if (s.truth) {
    s.board = s.truth->board;
    for (const Marker& m : s.truth->markers) (m.is_apriltag() ? s.apriltag : s.aruco) = m;
  }
  if (options.board) s.board = options.board;
  if (options.aruco) s.aruco = *options.aruco;
  if (options.apriltag) s.apriltag = *options.apriltag;
}

}  // namespace

Sequence open_sequence(const fs::path& given, const SequenceOptions& options) {
  const fs::path path =
      given == "sample" && !fs::exists(given) ? fs::path(io::data_file("sample")) : given;
  Sequence s;
  fs::path folder;
  if (fs::is_directory(path)) {
    folder = path;
    const fs::path whole = fs::weakly_canonical(path);
    s.name = whole.filename().string();
    s.video = (folder / "video.mp4").string();
    if (!fs::exists(s.video)) throw io::Error(path.string(), "has no video.mp4");
    if (fs::exists(folder / "truth.json")) s.truth = read_truth(folder / "truth.json");
  } else {
    s.name = path.stem().string();
    const bool names_none = s.name == "video" || s.name.find('%') != std::string::npos;
    if (names_none) s.name = fs::weakly_canonical(path).parent_path().filename().string();
    s.video = path.string();
  }
  find_camera(s, folder, options);
  find_hand(s, folder, options);
  find_prints(s, options);
  return s;
}

std::vector<Sequence> open_sequences(const std::vector<std::string>& paths,
                                     const SequenceOptions& options) {
  std::vector<Sequence> all;
  for (const std::string& path : paths) {
    Sequence s = open_sequence(path, options);
    const auto same = [&](const Sequence& other) { return other.name == s.name; };
    const std::string folder = fs::weakly_canonical(path).parent_path().filename().string();
    if (!folder.empty() && std::any_of(all.begin(), all.end(), same))
      s.name = folder + "-" + s.name;
    for (int i = 2; std::any_of(all.begin(), all.end(), same); ++i)
      s.name += "-" + std::to_string(i);
    all.push_back(std::move(s));
  }
  return all;
}

}  // namespace handyar::evaluation
