// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "handyar/attachment.hpp"

namespace handyar::render {

/// A printed square marker. Marker frame: origin at its centre, x right, y up, z out of the print.
struct SceneMarker {
  std::string dictionary;  ///< OpenCV's name: "DICT_4X4_50", "DICT_APRILTAG_36h11", ...
  int id = 0;
  double size_m = 0;  ///< outer side of the black square
  /// Where it stands in the world, when the scene says so; else that is learned while looking.
  std::optional<Eigen::Isometry3d> T_world_marker;
};

struct SceneObject {
  std::string name;
  std::string model;                                 ///< `teapot`, `bunny`, or a file
  Eigen::Vector3f colour = Eigen::Vector3f::Ones();  ///< multiplies the model's own, sRGB 0..1
  double size_m = 0.09;                              ///< longest side of the model
  Attachment attachment = Attachment::face;          ///< where it stands on the hand
  int marker = -1;  ///< index in Scene::markers; -1: its place is given in the world
  /// Its foot (+z up, +x its front) in the frame of its marker, or of the world.
  Eigen::Isometry3d T_marker_object = Eigen::Isometry3d::Identity();
};

/// World-stabilised objects and what holds the world: markers (paper 3.3), or a map that the hand
/// has set up.
struct Scene {
  std::string map;  ///< file of the map, without markers; empty: markers
  std::vector<SceneMarker> markers;
  std::vector<SceneObject> objects;
};

/// Reads a scene file (docs/formats.md); a model's path is taken from the file's folder. Everything
/// but the models themselves is checked; throws io::Error with one line that names file and fault.
Scene read_scene(const std::string& path);

/// Writes a scene of a map; its file and the models are told from the scene's folder where they lie
/// in it. Throws io::Error.
void write_scene(const std::string& path, const Scene& scene);

/// The same as read_scene from text; `path` stands for the file in messages and for its folder.
Scene parse_scene(std::string_view text, const std::string& path);

}  // namespace handyar::render
