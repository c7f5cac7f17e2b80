// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace handyar::render {

struct Vertex {
  Eigen::Vector3f position;
  Eigen::Vector3f normal;
  Eigen::Vector3f colour = Eigen::Vector3f::Ones();  ///< sRGB, 0..1
  Eigen::Vector2f uv = Eigen::Vector2f::Zero();
  float openness = 1;  ///< share of the sky seen from here, 0..1 (baked ambient occlusion)
};

/// How a texture goes on beyond its edges.
enum class Wrap : std::uint8_t { repeat, mirror, clamp };

/// How a surface answers light. `colour` multiplies the vertices' and the texture's.
struct Material {
  Eigen::Vector3f colour = Eigen::Vector3f::Ones();  ///< sRGB, 0..1
  float roughness = 0.4f;                            ///< 0 mirror .. 1 chalk
  float metallic = 0;                                ///< 0 .. 1
  cv::Mat texture;                                   ///< 8-bit RGBA, top row first; may be empty
  Wrap wrap_u = Wrap::repeat, wrap_v = Wrap::repeat;
  /// Light of its own, in full whatever falls on the surface: sRGB, multiplied by its texture
  /// (8-bit RGBA, laid like the other one) where that is not empty.
  Eigen::Vector3f emission = Eigen::Vector3f::Zero();
  cv::Mat emission_texture;
};

/// Triangles that share a material.
struct Mesh {
  /// Where the vertices are at one moment of the model's motion.
  struct Moment {
    std::vector<Eigen::Vector3f> positions, normals;
  };

  std::vector<Vertex> vertices;        ///< at first
  std::vector<Moment> moments;         ///< evenly over the model's period; empty: it does not move
  std::vector<std::uint32_t> indices;  ///< three per triangle
  Material material;
};

/// A 3-D object as loaded: +z up, its front towards +x, in the model's own units.
struct Model {
  std::vector<Mesh> meshes;
  double period_s = 0;  ///< of its motion, which goes on and on; 0: it has none

  /// Of all moments.
  Eigen::AlignedBox3f bounds() const;

  /// The same object standing on the origin: its lowest point at z = 0, its box centred on x = y =
  /// 0, its longest side 1.
  Model standing() const;
};

/// The Utah teapot from M. Newell's published control points; seen from its front, +x, the spout is
/// on the right.
Model teapot();

/// A sitting bunny, made for this project; it looks along +x.
Model bunny();

/// Reads OBJ, PLY, glTF and whatever else assimp can, with materials, textures and the first
/// animation (of nodes and bones, not of shapes); +y up and +z to the front in the file, as those
/// formats have it. Throws io::Error with one line that names the file.
Model load_model(const std::filesystem::path& path);

/// `teapot`, `bunny`, or a file; standing on the origin, its longest side 1. Throws as load_model.
Model find_model(const std::string& name_or_path);

}  // namespace handyar::render
