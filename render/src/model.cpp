// SPDX-License-Identifier: MIT
#include "handyar/render/model.hpp"

namespace handyar::render {

Eigen::AlignedBox3f Model::bounds() const {
  Eigen::AlignedBox3f box;
  for (const Mesh& mesh : meshes)
    for (const Vertex& v : mesh.vertices) box.extend(v.position);
  return box;
}

Model Model::standing() const {
  const Eigen::AlignedBox3f box = bounds();
  const Eigen::Vector3f foot(box.center().x(), box.center().y(), box.min().z());
  const float scale = 1.0f / box.sizes().maxCoeff();
  Model m = *this;
  for (Mesh& mesh : m.meshes)
    for (Vertex& v : mesh.vertices) v.position = scale * (v.position - foot);
  return m;
}

Model find_model(const std::string& name_or_path) {
  if (name_or_path == "teapot") return teapot().standing();
  if (name_or_path == "bunny") return bunny().standing();
  return load_model(name_or_path).standing();
}

}  // namespace handyar::render
