// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "gl.hpp"
#include "gpu_texture.hpp"
#include "handyar/render/model.hpp"

namespace handyar::render {

/// Triangles in buffers of the current context, with their material.
struct GpuMesh {
  gl::VertexArray array;
  gl::Buffer vertices, indices;
  SharedTexture texture, emission_texture;  ///< null: it has none
  GLsizei index_count = 0;
  Material material;
  std::vector<Mesh::Moment> moments;
  std::vector<Vertex> moved;  ///< what the buffer is filled with, where it moves

  GpuMesh(const Mesh& mesh, SharedTexture its_texture, SharedTexture its_emission_texture);

  /// `share`: of the model's period.
  void move(double share);
};

/// A standing model, with the ambient light and the shadow that are baked for it.
struct GpuModel {
  std::vector<GpuMesh> meshes;
  gl::Texture shadow;
  Eigen::AlignedBox3f box;  ///< standing, longest side 1
  double period_s;

  explicit GpuModel(Model model);
};

}  // namespace handyar::render
