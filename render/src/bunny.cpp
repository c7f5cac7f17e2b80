// SPDX-License-Identifier: MIT
#include <array>
#include <cmath>
#include <unordered_map>

#include "handyar/render/model.hpp"

namespace handyar::render {
namespace {

using Eigen::Vector3f;

/// An ellipsoid, leant about the y axis (positive: its top goes to -x) and mirrored in y = 0 where
/// it comes in pairs; `blend` is how far it melts into what was there before.
struct Ellipsoid {
  Vector3f centre, radii;
  float lean_rad;
  bool pair;
  float blend;

  /// Near the surface, the distance to it; negative inside.
  float distance(Vector3f p) const {
    if (pair) p.y() = std::abs(p.y());
    p -= centre;
    const float c = std::cos(lean_rad), s = std::sin(lean_rad);
    const Vector3f q(c * p.x() + s * p.z(), p.y(), c * p.z() - s * p.x());
    const float k0 = q.cwiseQuotient(radii).norm();
    const float k1 = q.cwiseQuotient(radii.cwiseProduct(radii)).norm();
    return k1 > 1e-6f ? k0 * (k0 - 1) / k1 : -radii.minCoeff();
  }
};

const Ellipsoid kEar{{0.20f, 0.125f, 1.40f}, {0.075f, 0.115f, 0.36f}, 0.30f, true, 0.05f};
const std::array<Ellipsoid, 11> kBody = {{
    {{-0.08f, 0, 0.42f}, {0.45f, 0.36f, 0.41f}, 0, false, 0},            // trunk
    {{-0.10f, 0.26f, 0.28f}, {0.30f, 0.17f, 0.27f}, 0.2f, true, 0.05f},  // haunches
    {{0.20f, 0, 0.52f}, {0.23f, 0.25f, 0.36f}, 0.2f, false, 0.12f},      // chest
    {{0.30f, 0.12f, 0.25f}, {0.09f, 0.085f, 0.26f}, 0, true, 0.05f},     // fore legs
    {{0.37f, 0.12f, 0.06f}, {0.16f, 0.09f, 0.08f}, 0, true, 0.05f},      // fore paws
    {{0.10f, 0.31f, 0.06f}, {0.27f, 0.11f, 0.085f}, 0, true, 0.05f},     // hind feet
    {{0.34f, 0, 0.98f}, {0.27f, 0.24f, 0.235f}, 0, false, 0.10f},        // head
    {{0.54f, 0, 0.90f}, {0.13f, 0.14f, 0.11f}, 0, false, 0.10f},         // muzzle
    {{0.40f, 0.14f, 0.88f}, {0.15f, 0.12f, 0.12f}, 0, true, 0.08f},      // cheeks
    kEar,                                                                // ears
    {{-0.54f, 0, 0.32f}, {0.15f, 0.15f, 0.15f}, 0, false, 0.03f},        // tail
}};

float smooth_min(float a, float b, float blend) {
  if (blend <= 0) return std::min(a, b);
  const float h = std::max(blend - std::abs(a - b), 0.0f) / blend;
  return std::min(a, b) - h * h * blend * 0.25f;
}

float body_distance(const Vector3f& p) {
  float d = kBody[0].distance(p);
  for (std::size_t i = 1; i < kBody.size(); ++i)
    d = smooth_min(d, kBody[i].distance(p), kBody[i].blend);
  return std::max(d, -p.z());  // it sits flat
}

Vector3f body_normal(const Vector3f& p) {
  constexpr float h = 0.004f;
  Vector3f g;
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3f step = h * Vector3f::Unit(axis);
    g[axis] = body_distance(p + step) - body_distance(p - step);
  }
  return g.normalized();
}

Vector3f fur_colour(const Vector3f& p, const Vector3f& n) {
  const Vector3f tan(0.78f, 0.62f, 0.45f), cream(0.97f, 0.93f, 0.86f), pink(0.93f, 0.64f, 0.62f);
  const auto ramp = [](float x, float a, float b) {
    const float t = std::clamp((x - a) / (b - a), 0.0f, 1.0f);
    return t * t * (3 - 2 * t);
  };
  // Cream on belly, muzzle, paws and tail.
  const float belly = ramp(n.x(), 0.1f, 0.8f) * ramp(p.z(), 0.85f, 0.6f) * ramp(p.x(), 0.1f, 0.3f);
  const float muzzle = ramp(p.x(), 0.48f, 0.58f) * ramp(p.z(), 1.05f, 0.95f);
  const float paws = ramp(p.z(), 0.16f, 0.08f);
  const float tail = ramp(p.x(), -0.44f, -0.52f);
  Vector3f c = tan + std::max({belly, muzzle, paws, tail}) * (cream - tan);
  // The hollow of the ear, seen from the front.
  Ellipsoid hollow = kEar;
  hollow.radii = {0.2f, 0.065f, 0.28f};
  const float ear = ramp(hollow.distance(p), 0.015f, -0.015f) * ramp(n.x(), 0.2f, 0.5f) *
                    ramp(p.z(), 1.15f, 1.25f);
  return c + ear * (pink - c);
}

/// The zero surface of `body_distance`: one vertex in every cell that it crosses (surface nets),
/// drawn onto it along the gradient.
Mesh body_mesh() {
  constexpr float kCell = 0.042f;
  const Vector3f low(-0.75f, -0.48f, -0.06f);
  const Eigen::Vector3i cells(36, 25, 46);
  const auto index = [&](int x, int y, int z) { return (z * cells.y() + y) * cells.x() + x; };
  const auto corner = [&](int x, int y, int z) {
    return Vector3f(low + kCell * Vector3f(x, y, z));
  };
  std::vector<float> d(static_cast<std::size_t>(cells.prod()));
  for (int z = 0; z < cells.z(); ++z)
    for (int y = 0; y < cells.y(); ++y)
      for (int x = 0; x < cells.x(); ++x) d[index(x, y, z)] = body_distance(corner(x, y, z));

  Mesh mesh;
  std::unordered_map<int, std::uint32_t> vertex_of_cell;
  const auto vertex_in = [&](int x, int y, int z) {
    const auto [it, fresh] = vertex_of_cell.try_emplace(
        index(x, y, z), static_cast<std::uint32_t>(mesh.vertices.size()));
    if (fresh) {
      Vector3f p = corner(x, y, z) + Vector3f::Constant(0.5f * kCell);
      for (int step = 0; step < 3; ++step)
        p -= std::clamp(body_distance(p), -0.5f * kCell, 0.5f * kCell) * body_normal(p);
      const Vector3f n = body_normal(p);
      mesh.vertices.push_back({p, n, fur_colour(p, n)});
    }
    return it->second;
  };
  // Every grid edge that crosses the surface is shared by four cells: a quad.
  for (int z = 1; z + 1 < cells.z(); ++z)
    for (int y = 1; y + 1 < cells.y(); ++y)
      for (int x = 1; x + 1 < cells.x(); ++x)
        for (int axis = 0; axis < 3; ++axis) {
          const Eigen::Vector3i a(x, y, z), e = Eigen::Vector3i::Unit(axis);
          const Eigen::Vector3i u = Eigen::Vector3i::Unit((axis + 1) % 3),
                                v = Eigen::Vector3i::Unit((axis + 2) % 3), b = a + e;
          const bool inside = d[index(a.x(), a.y(), a.z())] < 0;
          if (inside == (d[index(b.x(), b.y(), b.z())] < 0)) continue;
          std::array<std::uint32_t, 4> q;
          int i = 0;
          for (const Eigen::Vector3i& c :
               {a, Eigen::Vector3i(a - u), Eigen::Vector3i(a - u - v), Eigen::Vector3i(a - v)})
            q[i++] = vertex_in(c.x(), c.y(), c.z());
          if (!inside) std::swap(q[1], q[3]);
          mesh.indices.insert(mesh.indices.end(), {q[0], q[1], q[2], q[0], q[2], q[3]});
        }
  mesh.material.roughness = 0.8f;
  return mesh;
}

Mesh ball(const Ellipsoid& e, const Vector3f& colour, float roughness) {
  constexpr int kRings = 8, kSectors = 12;
  Mesh mesh;
  mesh.material.colour = colour;
  mesh.material.roughness = roughness;
  for (float side : e.pair ? std::vector<float>{1, -1} : std::vector<float>{1}) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (int r = 0; r <= kRings; ++r)
      for (int s = 0; s <= kSectors; ++s) {
        const float polar = static_cast<float>(M_PI) * r / kRings;
        const float around = static_cast<float>(2 * M_PI) * s / kSectors;
        const Vector3f n(std::sin(polar) * std::cos(around), std::sin(polar) * std::sin(around),
                         std::cos(polar));
        const Vector3f centre(e.centre.x(), side * e.centre.y(), e.centre.z());
        mesh.vertices.push_back({centre + e.radii.cwiseProduct(n), n});
      }
    for (std::uint32_t r = 0; r < kRings; ++r)
      for (std::uint32_t s = 0; s < kSectors; ++s) {
        const std::uint32_t a = first + r * (kSectors + 1) + s, b = a + kSectors + 1;
        mesh.indices.insert(mesh.indices.end(), {a, b, a + 1, a + 1, b, b + 1});
      }
  }
  return mesh;
}

}  // namespace

Model bunny() {
  const Ellipsoid eye{{0.475f, 0.185f, 1.04f}, {0.05f, 0.04f, 0.055f}, 0, true, 0};
  const Ellipsoid nose{{0.665f, 0, 0.945f}, {0.03f, 0.042f, 0.028f}, 0, false, 0};
  return {{body_mesh(), ball(eye, {0.05f, 0.04f, 0.04f}, 0.1f),
           ball(nose, {0.75f, 0.42f, 0.42f}, 0.4f)}};
}

}  // namespace handyar::render
