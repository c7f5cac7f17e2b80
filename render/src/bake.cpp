// SPDX-License-Identifier: MIT
#include "bake.hpp"

#include <opencv2/imgproc.hpp>
#include <vector>

namespace handyar::render {
namespace {

using Eigen::Vector3f;

constexpr int kCells = 40;  // of the longest side, which is 1
constexpr float kVoxel = 1.0f / kCells;
const Vector3f kLow(-0.5f, -0.5f, 0.0f);  // a standing model fits the unit cube above the ground

class Occupancy {
 public:
  explicit Occupancy(const Model& model) : filled_(kCells * kCells * kCells, 0) {
    for (const Mesh& mesh : model.meshes)
      for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
        const Vector3f& a = mesh.vertices[mesh.indices[i]].position;
        const Vector3f u = mesh.vertices[mesh.indices[i + 1]].position - a;
        const Vector3f v = mesh.vertices[mesh.indices[i + 2]].position - a;
        const int steps = 1 + static_cast<int>(2 * std::max(u.norm(), v.norm()) / kVoxel);
        for (int s = 0; s <= steps; ++s)
          for (int t = 0; t <= steps - s; ++t)
            fill(a + (u * float(s) + v * float(t)) / float(steps));
      }
  }

  bool operator()(const Vector3f& p) const {
    const int i = index(p);
    return i >= 0 && filled_[i];
  }

 private:
  static int index(const Vector3f& p) {
    const Eigen::Array3i c = ((p - kLow).array() / kVoxel).floor().cast<int>();
    if ((c < 0).any() || (c >= kCells).any()) return -1;
    return (c.z() * kCells + c.y()) * kCells + c.x();
  }
  void fill(const Vector3f& p) {
    const int i = index(p);
    if (i >= 0) filled_[i] = 1;
  }
  std::vector<char> filled_;
};

/// Directions spread evenly over the sphere (a Fibonacci spiral).
std::vector<Vector3f> directions(int count) {
  std::vector<Vector3f> all;
  for (int i = 0; i < count; ++i) {
    const float z = 1 - (2 * i + 1.0f) / count;
    const float angle = 2.39996323f * i;
    const float r = std::sqrt(1 - z * z);
    all.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
  }
  return all;
}

float openness(const Vertex& v, const Occupancy& filled, const std::vector<Vector3f>& rays) {
  constexpr float kReach = 0.45f;       // what is farther away does not darken
  constexpr float kGroundLight = 0.4f;  // what the ground throws back
  float open = 0, all = 0;
  for (const Vector3f& ray : rays) {
    const float cosine = ray.dot(v.normal);
    if (cosine <= 0.05f) continue;
    all += cosine;
    float light = 1;
    // The first steps are skipped: a surface does not shade itself.
    for (float t = 2.2f * kVoxel; t < kReach && light == 1; t += kVoxel) {
      const Vector3f p = v.position + 1.0f * kVoxel * v.normal + t * ray;
      if (p.z() < 0)
        light = kGroundLight;
      else if (filled(p))
        light = t / kReach * 0.6f;
    }
    open += light * cosine;
  }
  return all > 0 ? open / all : 1;
}

}  // namespace

void bake_openness(Model& model) {
  const Occupancy filled(model);
  const std::vector<Vector3f> rays = directions(64);
  for (Mesh& mesh : model.meshes)
    for (Vertex& v : mesh.vertices) v.openness = openness(v, filled, rays);
}

cv::Mat bake_shadow(const Model& model) {
  constexpr int kSize = 128;
  constexpr float kTouching = 0.07f;  // lower than this counts as touching the ground
  cv::Mat touching = cv::Mat::zeros(kSize, kSize, CV_8U), whole = touching.clone();
  for (const Mesh& mesh : model.meshes)
    for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
      cv::Point corners[3];
      float lowest = 1;
      for (int k = 0; k < 3; ++k) {
        const Vector3f& p = mesh.vertices[mesh.indices[i + k]].position;
        corners[k] = {cvRound((p.x() + 1) * kSize / 2 - 0.5f),
                      cvRound((p.y() + 1) * kSize / 2 - 0.5f)};
        lowest = std::min(lowest, p.z());
      }
      cv::fillConvexPoly(whole, corners, 3, 255);
      if (lowest < kTouching) cv::fillConvexPoly(touching, corners, 3, 255);
    }
  cv::GaussianBlur(touching, touching, {}, 0.035 * kSize / 2);
  cv::GaussianBlur(whole, whole, {}, 0.11 * kSize / 2);
  cv::Mat both;
  cv::merge(std::vector<cv::Mat>{touching, whole}, both);
  return both;
}

}  // namespace handyar::render
