// SPDX-License-Identifier: MIT
#include "handyar/render/model.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <tuple>

namespace handyar::render {
namespace {

/// Share of the surface whose stored normal agrees with its triangles' winding.
double agreement(const Mesh& mesh) {
  double good = 0, all = 0;
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const Vertex &a = mesh.vertices[mesh.indices[i]], &b = mesh.vertices[mesh.indices[i + 1]],
                 &c = mesh.vertices[mesh.indices[i + 2]];
    const Eigen::Vector3f n = (b.position - a.position).cross(c.position - a.position);
    all += n.norm();
    if (std::abs(n.dot(a.normal)) > 0.5f * n.norm()) good += n.norm();
  }
  return good / all;
}

TEST(Teapot, HasTheProportionsOfThePublishedOne) {
  const Model model = teapot();
  const Eigen::AlignedBox3f box = model.bounds();
  // From handle (-3.0) to spout (3.525 is a control point; the curve itself reaches 3.434), from
  // the table to the knob's top, and twice the body's radius of 2.
  EXPECT_NEAR(box.min().y(), -3.0, 0.02);
  EXPECT_NEAR(box.max().y(), 3.434, 0.02);
  EXPECT_NEAR(box.min().z(), 0, 1e-5);
  EXPECT_NEAR(box.max().z(), 3.15, 1e-5);
  EXPECT_NEAR(box.sizes().x(), 4.0, 0.02);
  EXPECT_GT(agreement(model.meshes[0]), 0.99);
}

TEST(Teapot, NormalsPointOutwards) {
  const Model model = teapot();
  for (const Vertex& v : model.meshes[0].vertices) {
    EXPECT_NEAR(v.normal.norm(), 1, 1e-4);
    const Eigen::Vector2f radial = v.position.head<2>();
    const bool belly = v.position.z() > 0.3f && v.position.z() < 2.2f &&
                       std::abs(radial.y()) < 1.2f && std::abs(radial.x()) > 1.0f;
    if (belly) {
      EXPECT_GT(v.normal.head<2>().dot(radial), 0);
    }
  }
}

TEST(Bunny, IsOneClosedSkin) {
  const Model model = bunny();
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  const Mesh& skin = model.meshes[0];
  for (std::size_t i = 0; i < skin.indices.size(); i += 3)
    for (int k = 0; k < 3; ++k) ++edges[{skin.indices[i + k], skin.indices[i + (k + 1) % 3]}];
  int open = 0;
  for (const auto& [edge, count] : edges) {
    const auto back = edges.find({edge.second, edge.first});
    open += back == edges.end() || back->second != count;
  }
  EXPECT_EQ(open, 0);
  EXPECT_GT(agreement(skin), 0.95);
  EXPECT_LT(skin.indices.size() / 3, 15000u);
}

TEST(Standing, PutsTheFootOnTheOriginAndTheLongestSideToOne) {
  for (const char* name : {"teapot", "bunny"}) {
    const Eigen::AlignedBox3f box = find_model(name).bounds();
    EXPECT_NEAR(box.min().z(), 0, 1e-5);
    EXPECT_NEAR(box.center().head<2>().norm(), 0, 1e-5);
    EXPECT_NEAR(box.sizes().maxCoeff(), 1, 1e-5);
  }
}

}  // namespace
}  // namespace handyar::render
