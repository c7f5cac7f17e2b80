// SPDX-License-Identifier: MIT
#include <array>
#include <cmath>

#include "handyar/render/model.hpp"

namespace handyar::render {
namespace {

using Patch = std::array<std::array<Eigen::Vector3f, 4>, 4>;

// M. Newell's control points (University of Utah, 1975), as given by F. Crow, "The Origins of the
// Teapot", IEEE Computer Graphics and Applications 7(1), 1987. 32 bicubic Bezier patches: six
// profiles turned about the z axis in four quarters, handle and spout mirrored in y = 0.

struct ProfilePoint {
  float r, z;
};
constexpr ProfilePoint kProfiles[6][4] = {
    {{1.4f, 2.4f}, {1.3375f, 2.53125f}, {1.4375f, 2.53125f}, {1.5f, 2.4f}},  // rim
    {{1.5f, 2.4f}, {1.75f, 1.875f}, {2.0f, 1.35f}, {2.0f, 0.9f}},            // body
    {{2.0f, 0.9f}, {2.0f, 0.45f}, {1.5f, 0.225f}, {1.5f, 0.15f}},
    {{0.0f, 3.15f}, {0.8f, 3.15f}, {0.0f, 2.85f}, {0.2f, 2.7f}},  // knob and lid
    {{0.2f, 2.7f}, {0.4f, 2.55f}, {1.3f, 2.55f}, {1.3f, 2.4f}},
    {{1.5f, 0.15f}, {1.5f, 0.075f}, {1.425f, 0.0f}, {0.0f, 0.0f}},  // bottom
};
constexpr float kQuarter[4][2] = {{1, 0}, {1, 0.56f}, {0.56f, 1}, {0, 1}};

/// One row across a tube: the side nearer the pot's axis or top, the far side, and the half width.
struct TubeRow {
  float x_near, z_near, x_far, z_far, half_width;
};
constexpr TubeRow kHandle[7] = {
    {-1.6f, 2.025f, -1.5f, 2.25f, 0.3f}, {-2.3f, 2.025f, -2.5f, 2.25f, 0.3f},
    {-2.7f, 2.025f, -3.0f, 2.25f, 0.3f}, {-2.7f, 1.8f, -3.0f, 1.8f, 0.3f},
    {-2.7f, 1.575f, -3.0f, 1.35f, 0.3f}, {-2.5f, 1.125f, -2.65f, 0.9375f, 0.3f},
    {-2.0f, 0.9f, -1.9f, 0.6f, 0.3f}};
constexpr TubeRow kSpout[7] = {
    {1.7f, 1.425f, 1.7f, 0.6f, 0.66f},       {2.6f, 1.425f, 3.1f, 0.825f, 0.66f},
    {2.3f, 2.1f, 2.4f, 2.025f, 0.25f},       {2.7f, 2.4f, 3.3f, 2.4f, 0.25f},
    {2.8f, 2.475f, 3.525f, 2.49375f, 0.25f}, {2.9f, 2.475f, 3.45f, 2.5125f, 0.15f},
    {2.8f, 2.4f, 3.2f, 2.4f, 0.15f}};

Patch turned(const ProfilePoint (&profile)[4], int quarter) {
  const Eigen::Matrix3f turn =
      Eigen::AngleAxisf(static_cast<float>(quarter * M_PI_2), Eigen::Vector3f::UnitZ())
          .toRotationMatrix();
  Patch p;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      p[i][j] = turn * Eigen::Vector3f(profile[i].r * kQuarter[j][0], profile[i].r * kQuarter[j][1],
                                       profile[i].z);
  return p;
}

Patch half_tube(const TubeRow* rows, float side) {
  Patch p;
  for (int i = 0; i < 4; ++i) {
    const TubeRow& r = rows[i];
    const float y = side * r.half_width;
    p[i] = {Eigen::Vector3f(r.x_near, 0, r.z_near), Eigen::Vector3f(r.x_near, y, r.z_near),
            Eigen::Vector3f(r.x_far, y, r.z_far), Eigen::Vector3f(r.x_far, 0, r.z_far)};
  }
  return p;
}

struct Bernstein {
  std::array<float, 4> value, slope;
  explicit Bernstein(float t)
      : value{(1 - t) * (1 - t) * (1 - t), 3 * t * (1 - t) * (1 - t), 3 * t * t * (1 - t),
              t * t * t},
        slope{-3 * (1 - t) * (1 - t), 3 * (1 - t) * (1 - 3 * t), 3 * t * (2 - 3 * t), 3 * t * t} {}
};

Vertex evaluate(const Patch& p, float u, float v) {
  // Where a row of control points falls together (knob, bottom) the normal is the limit from
  // inside.
  constexpr float kInside = 1e-3f;
  const Bernstein bu(u), bv(v), nu(std::clamp(u, kInside, 1 - kInside)), nv(v);
  Vertex vertex;
  vertex.position.setZero();
  Eigen::Vector3f du = Eigen::Vector3f::Zero(), dv = Eigen::Vector3f::Zero();
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) {
      vertex.position += bu.value[i] * bv.value[j] * p[i][j];
      du += nu.slope[i] * nv.value[j] * p[i][j];
      dv += nu.value[i] * nv.slope[j] * p[i][j];
    }
  vertex.normal = du.cross(dv).normalized();
  return vertex;
}

void add_patch(const Patch& patch, bool outwards, Mesh& mesh) {
  constexpr int kSteps = 8;
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (int i = 0; i <= kSteps; ++i)
    for (int j = 0; j <= kSteps; ++j) {
      Vertex v = evaluate(patch, float(i) / kSteps, float(j) / kSteps);
      if (!outwards) v.normal = -v.normal;
      mesh.vertices.push_back(v);
    }
  for (std::uint32_t i = 0; i < kSteps; ++i)
    for (std::uint32_t j = 0; j < kSteps; ++j) {
      const std::uint32_t a = first + i * (kSteps + 1) + j, b = a + kSteps + 1;
      mesh.indices.insert(mesh.indices.end(), {a, b, a + 1, a + 1, b, b + 1});
    }
}

}  // namespace

Model teapot() {
  Mesh mesh;  // with the spout along +x, as published
  for (const auto& profile : kProfiles)
    for (int quarter = 0; quarter < 4; ++quarter) add_patch(turned(profile, quarter), true, mesh);
  for (const TubeRow* tube : {kHandle, kSpout})
    for (int half : {0, 3})
      for (float side : {1.0f, -1.0f}) add_patch(half_tube(tube + half, side), side > 0, mesh);
  for (Vertex& v : mesh.vertices)
    for (Eigen::Vector3f* p : {&v.position, &v.normal}) *p = {-p->y(), p->x(), p->z()};
  mesh.material.colour = {0.93f, 0.90f, 0.84f};
  mesh.material.roughness = 0.25f;
  return {{mesh}};
}

}  // namespace handyar::render
