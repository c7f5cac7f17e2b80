// SPDX-License-Identifier: MIT
#include "motion.hpp"

#include <algorithm>
#include <cmath>

namespace handyar::render {
namespace {

using Eigen::Affine3f;
using Eigen::Vector3f;

Affine3f affine(const aiMatrix4x4& m) {
  using Rows = Eigen::Matrix<float, 4, 4, Eigen::RowMajor>;
  return Affine3f(Eigen::Map<const Rows>(&m.a1));
}

aiVector3D between(const aiVector3D& a, const aiVector3D& b, float share) {
  return a + (b - a) * share;
}
aiQuaternion between(const aiQuaternion& a, const aiQuaternion& b, float share) {
  aiQuaternion out;
  aiQuaternion::Interpolate(out, a, b, share);
  return out.Normalize();
}

/// The value at a time, of keys in the order of theirs; `rest` without any.
template <class Key, class Value>
Value at(const Key* keys, unsigned count, double ticks, const Value& rest) {
  if (count == 0) return rest;
  const Key* const after = std::upper_bound(keys, keys + count, ticks,
                                            [](double t, const Key& key) { return t < key.mTime; });
  if (after == keys) return keys->mValue;
  const Key& before = after[-1];
  if (after == keys + count) return before.mValue;
  return between(before.mValue, after->mValue,
                 static_cast<float>((ticks - before.mTime) / (after->mTime - before.mTime)));
}

const aiNodeAnim* channel_of(const aiScene& scene, const aiNode& node) {
  if (scene.mNumAnimations == 0) return nullptr;
  const aiAnimation& animation = *scene.mAnimations[0];
  aiNodeAnim** const end = animation.mChannels + animation.mNumChannels;
  aiNodeAnim** const found = std::find_if(animation.mChannels, end, [&](const aiNodeAnim* channel) {
    return channel->mNodeName == node.mName;
  });
  return found == end ? nullptr : *found;
}

}  // namespace

double period_s(const aiScene& scene) {
  if (scene.mNumAnimations == 0) return 0;
  const aiAnimation& animation = *scene.mAnimations[0];
  constexpr double kUsual_per_s = 25;  // where a file does not say
  const double ticks_per_s =
      animation.mTicksPerSecond > 0 ? animation.mTicksPerSecond : kUsual_per_s;
  const double period = animation.mDuration / ticks_per_s;
  return std::isfinite(period) && period > 0 ? period : 0;
}

NodePlaces::NodePlaces(const aiScene& scene, double share) : scene_(scene) {
  const double ticks = scene.mNumAnimations > 0 ? share * scene.mAnimations[0]->mDuration : 0;
  // Files have +y up and +z to the front; here these are +z and +x.
  Affine3f turned = Affine3f::Identity();
  turned.linear() << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  place(*scene.mRootNode, turned, ticks);
}

void NodePlaces::place(const aiNode& node, const Affine3f& T_model_parent, double ticks) {
  aiMatrix4x4 T = node.mTransformation;
  if (const aiNodeAnim* channel = channel_of(scene_, node)) {
    aiVector3D scale, position;
    aiQuaternion turn;
    T.Decompose(scale, turn, position);
    T = aiMatrix4x4(at(channel->mScalingKeys, channel->mNumScalingKeys, ticks, scale),
                    at(channel->mRotationKeys, channel->mNumRotationKeys, ticks, turn),
                    at(channel->mPositionKeys, channel->mNumPositionKeys, ticks, position));
  }
  const Affine3f& here = places_[&node] = T_model_parent * affine(T);
  for (unsigned i = 0; i < node.mNumChildren; ++i) place(*node.mChildren[i], here, ticks);
}

const Affine3f* NodePlaces::T_model_node(const aiString& name) const {
  const aiNode* const node = scene_.mRootNode->FindNode(name);
  return node ? &places_.at(node) : nullptr;
}

Mesh::Moment moment(const aiMesh& mesh, const aiNode& node, const NodePlaces& places) {
  const Affine3f& of_node = places.T_model_node(node);
  // What bones do not carry the node does.
  std::vector<Affine3f> carried(mesh.mNumVertices, Affine3f(Eigen::Matrix4f::Zero()));
  std::vector<float> left(mesh.mNumVertices, 1.0f);
  for (unsigned b = 0; b < mesh.mNumBones; ++b) {
    const aiBone& bone = *mesh.mBones[b];
    const Affine3f* const of_bone = places.T_model_node(bone.mName);
    if (!of_bone) continue;
    const Affine3f T = *of_bone * affine(bone.mOffsetMatrix);
    for (unsigned w = 0; w < bone.mNumWeights; ++w) {
      const aiVertexWeight& weight = bone.mWeights[w];
      if (weight.mVertexId >= mesh.mNumVertices) continue;
      carried[weight.mVertexId].matrix() += weight.mWeight * T.matrix();
      left[weight.mVertexId] -= weight.mWeight;
    }
  }
  Mesh::Moment out;
  for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
    Affine3f T = carried[i];
    T.matrix() += left[i] * of_node.matrix();
    const auto vector = [](const aiVector3D& v) { return Vector3f(v.x, v.y, v.z); };
    out.positions.push_back(T * vector(mesh.mVertices[i]));
    // The cofactors turn normals as the inverse would, but are there for flat things too.
    const Eigen::Matrix3f L = T.linear();
    Eigen::Matrix3f cofactors;
    for (int k = 0; k < 3; ++k) cofactors.col(k) = L.col((k + 1) % 3).cross(L.col((k + 2) % 3));
    const float side = L.determinant() < 0 ? -1.0f : 1.0f;
    out.normals.push_back((side * (cofactors * vector(mesh.mNormals[i]))).normalized());
  }
  return out;
}

}  // namespace handyar::render
