// SPDX-License-Identifier: MIT
#include "handyar/render/model.hpp"

#include <algorithm>

namespace handyar::render {

Eigen::AlignedBox3f Model::bounds() const {
  Eigen::AlignedBox3f box;
  for (const Mesh& mesh : meshes) {
    for (const Vertex& v : mesh.vertices) box.extend(v.position);
    for (const Mesh::Moment& moment : mesh.moments)
      for (const Eigen::Vector3f& position : moment.positions) box.extend(position);
  }
  return box;
}

Model Model::standing() const {
  const Eigen::AlignedBox3f box = bounds();
  const Eigen::Vector3f foot(box.center().x(), box.center().y(), box.min().z());
  const float scale = 1.0f / box.sizes().maxCoeff();
  Model m = *this;
  const auto stand = [&](Eigen::Vector3f& position) { position = scale * (position - foot); };
  for (Mesh& mesh : m.meshes) {
    for (Vertex& v : mesh.vertices) stand(v.position);
    for (Mesh::Moment& moment : mesh.moments)
      std::for_each(moment.positions.begin(), moment.positions.end(), stand);
  }
  return m;
}

Model find_model(const std::string& name_or_path) {
  if (name_or_path == "teapot") return teapot().standing();
  if (name_or_path == "bunny") return bunny().standing();
  return load_model(name_or_path).standing();
}

}  // namespace handyar::render
