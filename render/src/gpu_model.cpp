// SPDX-License-Identifier: MIT
#include "gpu_model.hpp"

#include <cstddef>
#include <map>
#include <tuple>
#include <utility>

#include "bake.hpp"

namespace handyar::render {
namespace {

void attribute(GLuint index, GLint size, std::size_t offset) {
  glEnableVertexAttribArray(index);
  glVertexAttribPointer(index, size, GL_FLOAT, GL_FALSE, sizeof(Vertex),
                        reinterpret_cast<const void*>(offset));
}

}  // namespace

GpuMesh::GpuMesh(const Mesh& mesh, SharedTexture its_texture, SharedTexture its_emission_texture)
    : texture(std::move(its_texture)),
      emission_texture(std::move(its_emission_texture)),
      index_count(static_cast<GLsizei>(mesh.indices.size())),
      material(mesh.material),
      moments(mesh.moments) {
  if (!moments.empty()) moved = mesh.vertices;
  glBindVertexArray(array);
  glBindBuffer(GL_ARRAY_BUFFER, vertices);
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(mesh.vertices.size() * sizeof(Vertex)),
               mesh.vertices.data(), GL_STATIC_DRAW);
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices);
  glBufferData(GL_ELEMENT_ARRAY_BUFFER,
               static_cast<GLsizeiptr>(mesh.indices.size() * sizeof(mesh.indices[0])),
               mesh.indices.data(), GL_STATIC_DRAW);
  // In the order of shaders::kObjectAttributes.
  attribute(0, 3, offsetof(Vertex, position));
  attribute(1, 3, offsetof(Vertex, normal));
  attribute(2, 3, offsetof(Vertex, colour));
  attribute(3, 2, offsetof(Vertex, uv));
  attribute(4, 1, offsetof(Vertex, openness));
  material.texture.release();
  material.emission_texture.release();
}

void GpuMesh::move(double share) {
  if (moments.empty()) return;
  const double at = share * static_cast<double>(moments.size());
  const auto k = static_cast<std::size_t>(at);
  const Mesh::Moment &before = moments[k % moments.size()],
                     &after = moments[(k + 1) % moments.size()];
  const auto weight = static_cast<float>(at - static_cast<double>(k));
  for (std::size_t i = 0; i < moved.size(); ++i) {
    moved[i].position = (1 - weight) * before.positions[i] + weight * after.positions[i];
    moved[i].normal = (1 - weight) * before.normals[i] + weight * after.normals[i];
  }
  glBindBuffer(GL_ARRAY_BUFFER, vertices);
  glBufferSubData(GL_ARRAY_BUFFER, 0, static_cast<GLsizeiptr>(moved.size() * sizeof(Vertex)),
                  moved.data());
}

GpuModel::GpuModel(Model model) : box(model.bounds()), period_s(model.period_s) {
  bake_openness(model);
  // Meshes may have one in common.
  std::map<std::tuple<const std::uint8_t*, Wrap, Wrap>, SharedTexture> textures;
  for (const Mesh& mesh : model.meshes) {
    const auto shared = [&, &material = mesh.material](const cv::Mat& picture) {
      SharedTexture& texture = textures[{picture.data, material.wrap_u, material.wrap_v}];
      if (!texture && !picture.empty())
        texture = uploaded(picture, material.wrap_u, material.wrap_v);
      return texture;
    };
    meshes.emplace_back(mesh, shared(mesh.material.texture),
                        shared(mesh.material.emission_texture));
  }
  const cv::Mat rg = bake_shadow(model);
  upload(shadow, 4, GL_RG8, rg.cols, rg.rows, GL_RG, GL_UNSIGNED_BYTE, rg.data);
}

}  // namespace handyar::render
