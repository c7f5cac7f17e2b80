// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "handyar/evaluation/truth.hpp"

namespace handyar::evaluation {

/// What a person says of own footage; what is left empty comes from the sequence's folder.
struct SequenceOptions {
  std::string camera_file, hand_file;
  bool uncalibrated = false;  ///< the average hand, though a measured one is known
  std::optional<Board> board;
  std::optional<Marker> aruco, apriltag;
};

/// A video with what is known about it.
struct Sequence {
  std::string name;
  std::string video;
  std::string origin_of_camera, origin_of_hand;  ///< for a reader, e.g. "truth.json"
  Camera camera;
  HandModel hand;
  std::optional<Truth> truth;
  std::optional<Board> board;
  Marker aruco{"DICT_4X4_50", -1, 0.08};
  Marker apriltag{kAprilTagDictionary, -1, 0.06};
};

/// A video file, or a folder with video.mp4 and, where there are such, truth.json, camera.yml and
/// hand.json; `sample` is the shipped one. Of a file, what lies beside it is not taken; one called
/// "video", and a series of pictures, has its folder's name. Throws io::Error.
Sequence open_sequence(const std::filesystem::path& path, const SequenceOptions& options);

/// The same for several; those with the same name are told apart by their folder's.
std::vector<Sequence> open_sequences(const std::vector<std::string>& paths,
                                     const SequenceOptions& options);

}  // namespace handyar::evaluation
