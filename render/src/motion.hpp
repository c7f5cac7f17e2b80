// SPDX-License-Identifier: MIT
#pragma once

#include <assimp/scene.h>

#include <Eigen/Geometry>
#include <unordered_map>

#include "handyar/render/model.hpp"

namespace handyar::render {

/// Seconds that the first animation of a file lasts; 0: it has none.
double period_s(const aiScene& scene);

/// Where the nodes of a file are at one moment of its first animation, or at rest.
class NodePlaces {
 public:
  /// `share`: of the animation's period, 0 to 1.
  NodePlaces(const aiScene& scene, double share);

  const Eigen::Affine3f& T_model_node(const aiNode& node) const { return places_.at(&node); }
  /// By name; null when there is none of it.
  const Eigen::Affine3f* T_model_node(const aiString& name) const;

 private:
  void place(const aiNode& node, const Eigen::Affine3f& T_model_parent, double ticks);

  const aiScene& scene_;
  std::unordered_map<const aiNode*, Eigen::Affine3f> places_;
};

/// A node's mesh at that moment: carried by the node, or by its bones where it has some.
Mesh::Moment moment(const aiMesh& mesh, const aiNode& node, const NodePlaces& places);

}  // namespace handyar::render
