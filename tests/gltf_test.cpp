// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "handyar/render/model.hpp"
#include "temporary_folder.hpp"

namespace handyar::render {
namespace {

class GltfFile : public testing::Test {
 protected:
  void write_picture(const std::string& name, const cv::Scalar& bgra) const {
    cv::imwrite((folder_ / name).string(), cv::Mat(4, 4, CV_8UC4, bgra));
  }

  /// A triangle at `nodes` nodes, with `attributes` besides its places: accessor 1 are texture
  /// coordinates, 2 others, and 3 colours of one half. Its pictures are a.png and b.png.
  Model read(const std::string& material, const std::string& attributes, int nodes = 1,
             const std::string& buffer = "corners.bin",
             const std::string& picture = "a.png") const {
    const float numbers[] = {0,   0,   0,   2,   0,   0,   0,   1,   0,     // places
                             0,   0,   1,   0,   0,   1,                    // texture coordinates
                             0.5, 0.5, 0.5, 0.5, 0.5, 0.5,                  // others
                             0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5};  // colours
    const auto decoded = [](std::string name) {
      for (auto at = name.find("%20"); at != std::string::npos; at = name.find("%20"))
        name.replace(at, 3, " ");
      return name;
    };
    std::ofstream(folder_ / decoded(buffer), std::ios::binary)
        .write(reinterpret_cast<const char*>(numbers), sizeof numbers);
    std::string list = "0", all = R"({"mesh": 0})";
    for (int i = 1; i < nodes; ++i) {
      list += ", " + std::to_string(i);
      all += R"(, {"mesh": 0})";
    }
    std::ofstream(folder_ / "m.gltf")
        << R"({"asset": {"version": "2.0"},
      "extensionsUsed": ["KHR_materials_pbrSpecularGlossiness", "KHR_texture_transform"], "scene": 0, "scenes": [{"nodes": [)"
        << list << R"(]}], "nodes": [)" << all << R"(],
      "meshes": [{"primitives": [{"attributes": {"POSITION": 0)"
        << attributes << R"(}, "material": 0}]}], "materials": [)" << material << R"(],
      "textures": [{"source": 0}, {"source": 1}, {"source": 0, "sampler": 0}],
      "samplers": [{"wrapS": 33071, "wrapT": 33648}],
      "images": [{"uri": ")"
        << picture << R"("}, {"uri": "b.png"}],
      "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
        {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2"},
        {"bufferView": 2, "componentType": 5126, "count": 3, "type": "VEC2"},
        {"bufferView": 3, "componentType": 5126, "count": 3, "type": "VEC3"}],
      "bufferViews": [{"buffer": 0, "byteLength": 36},
        {"buffer": 0, "byteOffset": 36, "byteLength": 24},
        {"buffer": 0, "byteOffset": 60, "byteLength": 24},
        {"buffer": 0, "byteOffset": 84, "byteLength": 36}],
      "buffers": [{"uri": ")"
        << buffer << R"(", "byteLength": 120}]})";
    return load_model(folder_ / "m.gltf");
  }

  const test::TemporaryFolder temporary_;
  const std::filesystem::path& folder_ = temporary_.path();
};

const std::string kTextured = R"({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}})";
const std::string kAtCoordinates = R"(, "TEXCOORD_0": 1)";

TEST_F(GltfFile, ColoursOfCornersAreOfLinearLightAsThoseOfMaterials) {
  const Model model = read(R"({"pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.5, 1]}})",
                           R"(, "COLOR_0": 3)");
  const Eigen::Vector3f half = Eigen::Vector3f::Constant(std::pow(0.5f, 1 / 2.2f));
  EXPECT_TRUE(model.meshes.at(0).material.colour.isApprox(half, 1e-5f));
  for (const Vertex& v : model.meshes[0].vertices) EXPECT_TRUE(v.colour.isApprox(half, 1e-5f));
}

TEST_F(GltfFile, OnlyAMaterialThatSaysSoHasHolesWhereItsTextureHas) {
  write_picture("a.png", {10, 20, 30, 0});
  for (const auto& [mode, alpha] : {std::pair{"", 255},
                                    {R"(, "alphaMode": "OPAQUE")", 255},
                                    {R"(, "alphaMode": "MASK")", 0},
                                    {R"(, "alphaMode": "BLEND")", 0}}) {
    const Model model = read(kTextured + mode + "}", kAtCoordinates);
    EXPECT_EQ(model.meshes.at(0).material.texture.at<cv::Vec4b>(0, 0), cv::Vec4b(30, 20, 10, alpha))
        << mode;
  }
}

TEST_F(GltfFile, AMaterialWithHolesStatesWhereTheyBegin) {
  write_picture("a.png", {10, 20, 30, 100});
  for (const auto& [cutoff, is_hole] : {std::pair{"", true},
                                        {R"(, "alphaCutoff": 0.3)", false},
                                        {R"(, "alphaCutoff": 0.6)", true},
                                        {R"(, "alphaCutoff": 0)", false}}) {
    const Model model = read(kTextured + R"(, "alphaMode": "MASK")" + cutoff + "}", kAtCoordinates);
    const cv::Vec4b pixel = model.meshes.at(0).material.texture.at<cv::Vec4b>(0, 0);
    EXPECT_EQ(pixel[3] < 128, is_hole) << cutoff;
    EXPECT_EQ(pixel[0], 30);
  }
}

// By the extension's own example: a quarter of the picture, turned by 90 degrees.
TEST_F(GltfFile, TextureLiesAsItsTransformSays) {
  write_picture("a.png", {10, 20, 30, 255});
  const Model model = read(R"({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0,
      "extensions": {"KHR_texture_transform": {
        "offset": [0.1, 1], "rotation": 1.5707963, "scale": [0.5, 0.25]}}}}})",
                           kAtCoordinates);
  const Eigen::Vector2f expected[] = {{0.1f, 1.0f}, {0.1f, 0.5f}, {0.35f, 1.0f}};
  ASSERT_EQ(model.meshes.at(0).vertices.size(), 3u);
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector2f uv = model.meshes[0].vertices[i].uv;
    const Eigen::Vector2f turns = uv - expected[i];
    EXPECT_NEAR((turns - turns.array().round().matrix()).norm(), 0, 1e-5) << uv.transpose();
  }
}

TEST_F(GltfFile, ATextureOfTheOlderWayLiesAsItsTransformSaysToo) {
  write_picture("a.png", {10, 20, 30, 255});
  const Model model = read(R"({"extensions": {"KHR_materials_pbrSpecularGlossiness":
      {"diffuseTexture": {"index": 0, "extensions": {
        "KHR_texture_transform": {"scale": [0.5, 0.25]}}}}}})",
                           kAtCoordinates);
  EXPECT_TRUE(model.meshes.at(0).vertices.at(1).uv.isApprox(Eigen::Vector2f(0.5f, 0)));
  EXPECT_TRUE(model.meshes[0].vertices.at(2).uv.isApprox(Eigen::Vector2f(0, 0.25f)));
}

TEST_F(GltfFile, ATextureGoesOnBeyondItsEdgesAsItsSamplerSays) {
  write_picture("a.png", {10, 20, 30, 255});
  const Material plain = read(kTextured + "}", kAtCoordinates).meshes.at(0).material;
  EXPECT_EQ(plain.wrap_u, Wrap::repeat);
  EXPECT_EQ(plain.wrap_v, Wrap::repeat);
  const Material sampled =
      read(R"({"pbrMetallicRoughness": {"baseColorTexture": {"index": 2}}})", kAtCoordinates)
          .meshes.at(0)
          .material;
  EXPECT_EQ(sampled.wrap_u, Wrap::clamp);
  EXPECT_EQ(sampled.wrap_v, Wrap::mirror);
}

TEST_F(GltfFile, WhatShinesByItselfDoesSoInItsColourAndPicture) {
  write_picture("b.png", {51, 102, 255, 255});
  const Material dark =
      read(R"({"emissiveTexture": {"index": 1}})", kAtCoordinates).meshes.at(0).material;
  EXPECT_TRUE(dark.emission.isZero());
  const Material light =
      read(R"({"emissiveFactor": [0.5, 1, 0], "emissiveTexture": {"index": 1}})", kAtCoordinates)
          .meshes.at(0)
          .material;
  EXPECT_TRUE(light.emission.isApprox(Eigen::Vector3f(std::pow(0.5f, 1 / 2.2f), 1, 0), 1e-5f));
  ASSERT_FALSE(light.emission_texture.empty());
  EXPECT_EQ(light.emission_texture.at<cv::Vec4b>(0, 0), cv::Vec4b(255, 102, 51, 255));
}

TEST_F(GltfFile, WhereNothingElseIsTheTextureOfTheEmissionSaysHowItLies) {
  write_picture("a.png", {10, 20, 30, 255});
  const Mesh mesh =
      read(R"({"emissiveFactor": [1, 1, 1], "emissiveTexture": {"index": 2, "texCoord": 1,
      "extensions": {"KHR_texture_transform": {"offset": [0.25, 0]}}}})",
           R"(, "TEXCOORD_0": 1, "TEXCOORD_1": 2)")
          .meshes.at(0);
  EXPECT_EQ(mesh.material.wrap_u, Wrap::clamp);
  EXPECT_EQ(mesh.material.wrap_v, Wrap::mirror);
  EXPECT_TRUE(mesh.vertices.at(0).uv.isApprox(Eigen::Vector2f(0.75f, 0.5f)));
}

TEST_F(GltfFile, RoughnessAndMetalAreThoseOfTheTextureInTheMean) {
  write_picture("b.png", {51, 102, 255, 255});  // blue: metal, green: roughness
  const Model textured = read(
      R"({"pbrMetallicRoughness": {"roughnessFactor": 0.5, "metallicRoughnessTexture": {"index": 1}}})",
      kAtCoordinates);
  EXPECT_NEAR(textured.meshes.at(0).material.roughness, 0.5 * 102 / 255, 1e-5);
  EXPECT_NEAR(textured.meshes[0].material.metallic, 51 / 255.0, 1e-5);
  const Model plain = read(R"({"pbrMetallicRoughness": {"metallicFactor": 0}})", "");
  EXPECT_EQ(plain.meshes.at(0).material.roughness, 1);
  EXPECT_EQ(plain.meshes[0].material.metallic, 0);
}

TEST_F(GltfFile, WhatIsToldByItsGlossIsNoMetal) {
  const Model model = read(R"({"extensions": {"KHR_materials_pbrSpecularGlossiness":
                               {"diffuseFactor": [0.5, 0.5, 0.5, 1], "glossinessFactor": 0.25}}})",
                           "");
  const Material& material = model.meshes.at(0).material;
  EXPECT_EQ(material.roughness, 0.75f);
  EXPECT_EQ(material.metallic, 0);
  EXPECT_NEAR(material.colour.y(), std::pow(0.5, 1 / 2.2), 1e-5);
}

TEST_F(GltfFile, NamesOfFilesAreReadAsUris) {
  write_picture("the skin.png", {10, 20, 30, 255});
  const Model model =
      read(kTextured + "}", kAtCoordinates, 1, "the%20corners.bin", "the%20skin.png");
  EXPECT_EQ(model.meshes.at(0).material.texture.at<cv::Vec4b>(0, 0), cv::Vec4b(30, 20, 10, 255));
}

TEST_F(GltfFile, ATextureOfSeveralMeshesIsThereOnce) {
  write_picture("a.png", {10, 20, 30, 255});
  const Model model = read(kTextured + "}", kAtCoordinates, 3);
  ASSERT_EQ(model.meshes.size(), 3u);
  for (const Mesh& mesh : model.meshes)
    EXPECT_EQ(mesh.material.texture.data, model.meshes[0].material.texture.data);
}

TEST_F(GltfFile, ATextureLiesWhereTheCoordinatesThatItNamesHaveIt) {
  write_picture("a.png", {10, 20, 30, 255});
  const auto third_corner = [&](const std::string& texture) {
    const Model model =
        read(R"({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0)" + texture + "}}}",
             kAtCoordinates + R"(, "TEXCOORD_1": 2)");
    return model.meshes.at(0).vertices.at(2).uv;
  };
  EXPECT_TRUE(third_corner("").isApprox(Eigen::Vector2f(0, 1)));
  const Eigen::Vector2f other(0.5, 0.5);
  EXPECT_TRUE(third_corner(R"(, "texCoord": 1)").isApprox(other));
  const std::string by = R"(, "extensions": {"KHR_texture_transform": {"texCoord": 1}})";
  EXPECT_TRUE(third_corner(by).isApprox(other));
}

TEST_F(GltfFile, CornersThatLieTogetherFollowTheirOwnBones) {
  // Two triangles side by side, each on a bone of its own; the second bone is 3 higher than it was.
  std::string buffer;
  const auto add = [&](std::initializer_list<float> numbers) {
    buffer.append(reinterpret_cast<const char*>(numbers.begin()), numbers.size() * sizeof(float));
  };
  add({0, 0, 0, 2, 0, 0, 0, 1, 0, 2, 0, 0, 2, 1, 0, 0, 1, 0});
  for (int corner = 0; corner < 6; ++corner) add({1, 0, 0, 0});
  for (const char joint : {0, 0, 0, 1, 1, 1}) buffer.append({joint, 0, 0, 0});
  for (int joint = 0; joint < 2; ++joint) add({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1});
  std::ofstream(folder_ / "boned.bin", std::ios::binary) << buffer;
  std::ofstream(folder_ / "boned.gltf") << R"({"asset": {"version": "2.0"}, "scene": 0,
      "scenes": [{"nodes": [0, 1, 2]}],
      "nodes": [{"mesh": 0, "skin": 0}, {"name": "low"}, {"name": "high", "translation": [0, 3, 0]}],
      "skins": [{"joints": [1, 2], "inverseBindMatrices": 3}],
      "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "WEIGHTS_0": 1, "JOINTS_0": 2}}]}],
      "accessors": [{"bufferView": 0, "componentType": 5126, "count": 6, "type": "VEC3"},
        {"bufferView": 1, "componentType": 5126, "count": 6, "type": "VEC4"},
        {"bufferView": 2, "componentType": 5121, "count": 6, "type": "VEC4"},
        {"bufferView": 3, "componentType": 5126, "count": 2, "type": "MAT4"}],
      "bufferViews": [{"buffer": 0, "byteLength": 72},
        {"buffer": 0, "byteOffset": 72, "byteLength": 96},
        {"buffer": 0, "byteOffset": 168, "byteLength": 24},
        {"buffer": 0, "byteOffset": 192, "byteLength": 128}],
      "buffers": [{"uri": "boned.bin", "byteLength": 320}]})";
  const Model model = load_model(folder_ / "boned.gltf");
  const Mesh& mesh = model.meshes.at(0);
  ASSERT_EQ(mesh.indices.size(), 6u);
  for (std::size_t i = 0; i < 6; ++i) {
    const float z = mesh.vertices.at(mesh.indices[i]).position.z();
    EXPECT_TRUE(i < 3 ? z >= 0 && z <= 1 : z >= 3 && z <= 4) << "corner " << i << " at " << z;
  }
}

}  // namespace
}  // namespace handyar::render
