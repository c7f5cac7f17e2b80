// SPDX-License-Identifier: MIT
// What of a material is drawn.
#include <algorithm>
#include <string>
#include <utility>

#include "rendered_scene.hpp"

namespace handyar::render {
namespace {

class RendererMaterialTest : public RendererTest {};

TEST_F(RendererMaterialTest, RoughMetalIsAsBrightAsChalkOfItsColour) {
  const Isometry3d T = hand_at(0.45);
  double seen[2];
  for (const int metal : {0, 1}) {
    Model model = cube();
    model.meshes[0].material.roughness = 1;
    model.meshes[0].material.metallic = static_cast<float>(metal);
    Instance instance = red(T);
    instance.colour = {1, 1, 1};
    instance.model = renderer.add(model);
    seen[metal] = at(drawn(instance, T), T * Vector3d(0, 0, 0.06))[1];
  }
  EXPECT_NEAR(seen[1], seen[0], 0.1 * seen[0]);
}

TEST_F(RendererMaterialTest, ATextureLargerThanTheCardTakesIsShrunk) {
  Model model = cube();
  model.meshes[0].material.texture = cv::Mat(1, 40000, CV_8UC4, cv::Scalar(255, 0, 0, 255));
  const Isometry3d T = hand_at(0.45);
  Instance instance = red(T);
  instance.colour = {1, 1, 1};
  instance.model = renderer.add(model);
  EXPECT_TRUE(is_red(at(drawn(instance, T), T * Vector3d(0, 0, 0.06))));
}

/// A square on the ground, seen from above, with a picture of four colours.
Model carpet() {
  Model model;
  Mesh& mesh = model.meshes.emplace_back();
  for (const float y : {-0.5f, 0.5f})
    for (const float x : {-0.5f, 0.5f}) {
      Vertex& v =
          mesh.vertices.emplace_back(Vertex{{x, y, 0.001f * (x + 0.5f)}, Eigen::Vector3f::UnitZ()});
      v.uv = {x + 0.5f, y + 0.5f};
    }
  mesh.indices = {0, 1, 2, 2, 1, 3};
  cv::Mat& rgba = mesh.material.texture;
  rgba.create(64, 64, CV_8UC4);
  rgba({0, 0, 32, 32}).setTo(cv::Scalar(255, 0, 0, 255));
  rgba({32, 0, 32, 32}).setTo(cv::Scalar(0, 255, 0, 255));
  rgba({0, 32, 32, 32}).setTo(cv::Scalar(0, 0, 255, 255));
  rgba({32, 32, 32, 32}).setTo(cv::Scalar(255, 255, 255, 255));
  return model;
}

TEST_F(RendererMaterialTest, ATextureLiesWhereItsCoordinatesSay) {
  const Isometry3d T = hand_at(0.45);
  Instance instance = red(T, 0.1);
  instance.colour = {1, 1, 1};
  instance.model = renderer.add(carpet());
  const cv::Mat out = drawn(instance, T);
  const auto colour = [&](double x_m, double y_m) { return at(out, T * Vector3d(x_m, y_m, 0)); };
  EXPECT_TRUE(is_red(colour(-0.025, -0.025)));
  const cv::Vec3b green = colour(0.025, -0.025), blue = colour(-0.025, 0.025),
                  white = colour(0.025, 0.025);
  EXPECT_GT(green[1], 2 * std::max(green[0], green[2]));
  EXPECT_GT(blue[0], 2 * std::max(blue[1], blue[2]));
  EXPECT_GT(*std::min_element(white.val, white.val + 3), 100);
}

TEST_F(RendererMaterialTest, ATextureWithHolesShowsTheRoomThroughThem) {
  Model model = carpet();
  model.meshes[0].material.texture({32, 32, 32, 32}).setTo(cv::Scalar(255, 255, 255, 0));
  const Isometry3d T = hand_at(0.45);
  Instance instance = red(T, 0.1);
  instance.model = renderer.add(model);
  const cv::Mat out = drawn(instance, T);
  EXPECT_EQ(at(out, T * Vector3d(0.025, 0.025, 0)), kRoom);
  EXPECT_TRUE(is_red(at(out, T * Vector3d(-0.025, -0.025, 0))));
}

TEST_F(RendererMaterialTest, ATextureGoesOnBeyondItsEdgesAsItsWrapModesSay) {
  const Isometry3d T = hand_at(0.45);
  const auto letter = [](const cv::Vec3b& c) {  // of the picture's colour
    if (is_red(c)) return 'r';
    return c[1] > c[0] ? 'g' : 'b';
  };
  const std::string along_u[] = {"rgrg", "rggr", "rggg"}, along_v[] = {"rbrb", "rbbr", "rbbb"};
  for (const int u : {0, 1, 2}) {
    const int v = (u + 1) % 3;
    Model model = carpet();
    Material& material = model.meshes[0].material;
    material.wrap_u = static_cast<Wrap>(u);
    material.wrap_v = static_cast<Wrap>(v);
    for (Vertex& corner : model.meshes[0].vertices) corner.uv *= 2;
    Instance instance = red(T, 0.1);
    instance.colour = {1, 1, 1};
    instance.model = renderer.add(model);
    const cv::Mat out = drawn(instance, T);
    std::string seen_u, seen_v;
    for (const double at_m : {-0.0375, -0.0125, 0.0125, 0.0375}) {
      seen_u += letter(at(out, T * Vector3d(at_m, -0.0375, 0)));
      seen_v += letter(at(out, T * Vector3d(-0.0375, at_m, 0)));
    }
    EXPECT_EQ(seen_u, along_u[u]);
    EXPECT_EQ(seen_v, along_v[v]);
  }
}

TEST_F(RendererMaterialTest, WhatShinesByItselfIsSeenInTheDark) {
  const Isometry3d T = hand_at(0.45);
  Model model = cube();
  model.meshes[0].material.emission = {0, 1, 0};
  Instance instance = red(T);
  instance.colour = {0, 0, 0};
  instance.model = renderer.add(model);
  cv::Mat dark(480, 640, CV_8UC3, cv::Scalar(0, 0, 0));
  renderer.draw(dark, camera, {&instance, 1});
  const cv::Vec3b seen = at(dark, T * Vector3d(0, 0, 0.06));
  EXPECT_EQ(seen[1], 255);
  EXPECT_LT(std::max(seen[0], seen[2]), 60);
}

TEST_F(RendererMaterialTest, WhatShinesByItselfDoesSoWhereItsPictureDoes) {
  const Isometry3d T = hand_at(0.45);
  Model model = carpet();
  Material& material = model.meshes[0].material;
  std::swap(material.texture, material.emission_texture);
  material.emission = {1, 0, 1};
  Instance instance = red(T, 0.1);
  instance.colour = {0, 0, 0};
  instance.model = renderer.add(model);
  cv::Mat dark(480, 640, CV_8UC3, cv::Scalar(0, 0, 0));
  renderer.draw(dark, camera, {&instance, 1});
  const auto shines = [&](double x_m, double y_m) {
    const cv::Vec3b c = at(dark, T * Vector3d(x_m, y_m, 0));
    EXPECT_LT(c[1], 60);
    return cv::Vec2b(c[0] == 255, c[2] == 255);  // blue, red
  };
  EXPECT_EQ(shines(-0.025, -0.025), cv::Vec2b(0, 1));
  EXPECT_EQ(shines(0.025, -0.025), cv::Vec2b(0, 0)) << "its picture is green there";
  EXPECT_EQ(shines(-0.025, 0.025), cv::Vec2b(1, 0));
  EXPECT_EQ(shines(0.025, 0.025), cv::Vec2b(1, 1));
}

}  // namespace
}  // namespace handyar::render
