// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "handyar/io/error.hpp"
#include "handyar/render/model.hpp"
#include "temporary_folder.hpp"

namespace handyar::render {
namespace {

class ModelFile : public testing::Test {
 protected:
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return (folder_ / name).string();
  }

  /// A triangle 2 wide and 1 high, doubled by the root of the file, and a node that goes up by 3
  /// in two seconds. It hangs on that node; or, `boned`, its second corner does, and the third by
  /// half.
  std::string write_moving(bool boned) const {
    std::string buffer;
    const auto add = [&](std::initializer_list<float> numbers) {
      buffer.append(reinterpret_cast<const char*>(numbers.begin()), numbers.size() * sizeof(float));
    };
    add({0, 0, 0, 2, 0, 0, 0, 1, 0});                     // corners
    add({0, 2});                                          // times
    add({0, 0, 0, 0, 3, 0});                              // places
    add({1, 0, 0, 0, 0, 1, 0, 0, 0.5f, 0.5f, 0, 0});      // weights of joints
    buffer.append({0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0});  // joints
    for (int joint = 0; joint < 2; ++joint) add({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1});
    write("moving.bin", buffer);
    const std::string mesh = boned ? R"(, "mesh": 0, "skin": 0)" : R"(, "mesh": 0)";
    return write("moving.gltf", R"({"asset": {"version": "2.0"}, "scene": 0,
      "scenes": [{"nodes": [0]}], "nodes": [{"name": "root", "scale": [2, 2, 2], "children": [1, 2]},
        {"name": "still")" + (boned ? mesh : "") +
                                    R"(}, {"name": "goes up")" + (boned ? "" : mesh) + R"(}],
      "skins": [{"joints": [1, 2], "inverseBindMatrices": 5}],
      "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "WEIGHTS_0": 3, "JOINTS_0": 4}}]}],
      "animations": [{"channels": [{"sampler": 0, "target": {"node": 2, "path": "translation"}}],
        "samplers": [{"input": 1, "output": 2}]}],
      "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
        {"bufferView": 1, "componentType": 5126, "count": 2, "type": "SCALAR"},
        {"bufferView": 2, "componentType": 5126, "count": 2, "type": "VEC3"},
        {"bufferView": 3, "componentType": 5126, "count": 3, "type": "VEC4"},
        {"bufferView": 4, "componentType": 5121, "count": 3, "type": "VEC4"},
        {"bufferView": 5, "componentType": 5126, "count": 2, "type": "MAT4"}],
      "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 36},
        {"buffer": 0, "byteOffset": 36, "byteLength": 8},
        {"buffer": 0, "byteOffset": 44, "byteLength": 24},
        {"buffer": 0, "byteOffset": 68, "byteLength": 48},
        {"buffer": 0, "byteOffset": 116, "byteLength": 12},
        {"buffer": 0, "byteOffset": 128, "byteLength": 128}],
      "buffers": [{"uri": "moving.bin", "byteLength": 256}]})");
  }

  /// The same file with one thing in it put otherwise, once.
  std::string complaint_of(const std::string& before, const std::string& after) const {
    std::ifstream file(write_moving(true));
    std::string text{std::istreambuf_iterator<char>(file), {}};
    const std::size_t at = text.find(before);
    EXPECT_NE(at, std::string::npos) << before;
    return complaint(write("other.gltf", text.replace(at, before.size(), after)));
  }

  std::string complaint(const std::string& path) const {
    testing::internal::CaptureStderr();
    try {
      load_model(path);
      testing::internal::GetCapturedStderr();
    } catch (const io::Error& e) {
      const std::string said = e.what();
      EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << said;
      EXPECT_EQ(said.find(path), 0u) << said;
      EXPECT_EQ(said.find('\n'), std::string::npos) << said;
      return said;
    }
    return "";
  }

  const test::TemporaryFolder temporary_;
  const std::filesystem::path& folder_ = temporary_.path();
};

TEST_F(ModelFile, ReadsAnObjWithItsTexture) {
  // A square upright in the file's x-y plane (y up); its lower left quarter is red.
  cv::Mat picture(2, 2, CV_8UC3, cv::Scalar(255, 255, 255));
  picture.at<cv::Vec3b>(1, 0) = {0, 0, 255};
  cv::imwrite((folder_ / "t.png").string(), picture);
  write("m.mtl", "newmtl skin\nKd 1 1 1\nmap_Kd t.png\n");
  const std::string path =
      write("m.obj",
            "mtllib m.mtl\nv 0 0 0\nv 2 0 0\nv 2 3 0\nv 0 3 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
            "usemtl skin\nf 1/1 2/2 3/3 4/4\n");
  const Model model = load_model(path);
  ASSERT_EQ(model.meshes.size(), 1u);
  const Eigen::AlignedBox3f box = model.bounds();
  EXPECT_TRUE(box.sizes().isApprox(Eigen::Vector3f(0, 2, 3), 1e-5f)) << box.sizes();
  EXPECT_EQ(model.meshes[0].indices.size(), 6u);
  const cv::Mat& texture = model.meshes[0].material.texture;
  ASSERT_EQ(texture.type(), CV_8UC4);
  EXPECT_EQ(texture.at<cv::Vec4b>(1, 0), cv::Vec4b(255, 0, 0, 255));
  for (const Vertex& v : model.meshes[0].vertices)  // the file's v goes up, the picture's rows down
    EXPECT_NEAR(v.uv.y(), v.position.z() > 1 ? 0 : 1, 1e-5);
}

TEST_F(ModelFile, FindsATextureThatWindowsNamed) {
  std::filesystem::create_directory(folder_ / "pictures");
  cv::imwrite((folder_ / "pictures/t.png").string(), cv::Mat(2, 2, CV_8UC3, cv::Scalar(0, 0, 255)));
  write("m.mtl", "newmtl skin\nmap_Kd pictures\\t.png\n");
  const std::string path = write("m.obj",
                                 "mtllib m.mtl\nv 0 0 0\nv 2 0 0\nv 2 3 0\nvt 0 0\nvt 1 0\n"
                                 "vt 1 1\nusemtl skin\nf 1/1 2/2 3/3\n");
  EXPECT_FALSE(load_model(path).meshes.at(0).material.texture.empty());
}

TEST_F(ModelFile, NormalsWithoutALengthAreNone) {
  const Model model = load_model(
      write("m.stl",
            "solid m\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
            "endloop\nendfacet\nendsolid m\n"));
  ASSERT_EQ(model.meshes.at(0).vertices.size(), 3u);
  for (const Vertex& v : model.meshes[0].vertices)
    EXPECT_TRUE(v.normal.isApprox(Eigen::Vector3f::UnitX(), 1e-5f)) << v.normal.transpose();
}

TEST_F(ModelFile, ReadsAPlyWithColours) {
  const std::string path =
      write("m.ply",
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
            "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
            "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
            "0 0 0 255 0 0\n1 0 0 255 0 0\n0 1 0 255 0 0\n3 0 1 2\n");
  const Model model = load_model(path);
  EXPECT_TRUE(model.meshes.at(0).vertices.at(0).colour.isApprox(Eigen::Vector3f(1, 0, 0), 1e-5f));
}

TEST_F(ModelFile, ReadsHowNodesAndBonesMove) {
  for (const bool boned : {false, true}) {
    const Model model = load_model(write_moving(boned));
    EXPECT_NEAR(model.period_s, 2, 1e-6);
    ASSERT_EQ(model.meshes.size(), 1u);
    const Mesh& mesh = model.meshes[0];
    ASSERT_EQ(mesh.moments.size(), 40u);
    ASSERT_EQ(mesh.vertices.size(), 3u);
    for (std::size_t i = 0; i < 3; ++i) {
      const Eigen::Vector3f& first = mesh.vertices[i].position;
      const float carried = !boned ? 1 : first.y() > 3 ? 1 : first.z() > 1 ? 0.5f : 0;
      for (const std::size_t k : {0u, 10u, 30u}) {
        const Eigen::Vector3f up(0, 0, carried * 6 * static_cast<float>(k) / 40);
        EXPECT_TRUE(mesh.moments[k].positions[i].isApprox(first + up, 1e-5f)) << i << " at " << k;
        EXPECT_NEAR(mesh.moments[k].normals[i].norm(), 1, 1e-5);
      }
    }
    EXPECT_TRUE(
        model.bounds().sizes().isApprox(Eigen::Vector3f(0, 4, boned ? 5.85f : 7.85f), 1e-4f))
        << model.bounds().sizes().transpose();
  }
}

std::string ply(const std::string& format, int vertices, int faces, const std::string& body) {
  return "ply\nformat " + format + " 1.0\nelement vertex " + std::to_string(vertices) +
         "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
         std::to_string(faces) + "\nproperty list uchar int vertex_indices\nend_header\n" + body;
}

// assimp alone ends the program at these, or never returns.
TEST_F(ModelFile, RefusesAPlyWhoseCountsAreWrong) {
  const std::string corners = "0 0 0\n1 0 0\n0 1 0\n";
  EXPECT_EQ(complaint(write("good.ply", ply("ascii", 3, 1, corners + "3 0 1 2"))), "");
  for (const char* face : {"3 0 1 9\n", "3 0 1 -2\n", "0\n"})
    EXPECT_NE(complaint(write("m.ply", ply("ascii", 3, 1, corners + face)))
                  .find("has a face with a corner that is not there"),
              std::string::npos)
        << face;
  for (const auto& [vertices, faces] :
       std::vector<std::pair<int, int>>{{3, 2}, {100000000, 1}, {3, 100000000}, {-3, 1}})
    EXPECT_NE(complaint(write("m.ply", ply("ascii", vertices, faces, corners + "3 0 1 2\n")))
                  .find("breaks off"),
              std::string::npos)
        << vertices << " " << faces;
  EXPECT_NE(complaint(write("m.ply", ply("ascii", 3, 1, corners + "200000000 0 1 2\n"))), "");

  const float xyz[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  const std::int32_t face[] = {0, 1, 2};
  const std::string body = std::string(reinterpret_cast<const char*>(xyz), sizeof xyz) + '\3' +
                           std::string(reinterpret_cast<const char*>(face), sizeof face);
  const auto binary = [&](const std::string& bytes) {
    return complaint(write("m.ply", ply("binary_little_endian", 3, 1, bytes)));
  };
  EXPECT_EQ(binary(body), "");
  for (std::size_t kept = 0; kept < body.size(); ++kept)
    EXPECT_NE(binary(body.substr(0, kept)).find("breaks off"), std::string::npos) << kept;
}

// assimp 5.2 alone ends the program at some of these, or reads beyond what is there.
TEST_F(ModelFile, RefusesABrokenGltf) {
  EXPECT_EQ(complaint_of("root", "root"), "");
  const std::string matrices = R"(, "inverseBindMatrices": 5)",
                    times = R"("count": 2, "type": "MAT4")";
  const std::string image = R"("images": [{"bufferView": 0, "mimeType": ")", asset = R"("asset")";
  const auto nested = [](std::size_t deep) {
    return R"("extras": )" + std::string(deep, '[') + std::string(deep, ']') + R"(, "asset")";
  };
  const auto chain = [](std::size_t long_, const std::string& last) {
    std::string nodes;
    for (std::size_t i = 3; i < long_ + 2; ++i)
      nodes += R"(, {"children": [)" + std::to_string(i + 1) + "]}";
    return nodes + ", {" + last + R"(}], "skins")";
  };
  const std::string end = R"(],
      "skins")";
  EXPECT_EQ(complaint_of(asset, nested(50)), "");
  EXPECT_EQ(complaint_of(end, chain(200, "")), "");
  EXPECT_EQ(complaint_of(asset, R"("extensionsRequired": ["KHR_materials_unlit"], "asset")"), "");
  const struct {
    std::string before, after, fault;
  } broken[] = {
      {matrices, "", "a skin without inverseBindMatrices"},
      {matrices, R"(, "inverseBindMatrices": 9)", "a skin without inverseBindMatrices"},
      {R"({"joints": [1, 2], "inverseBindMatrices": 5})", "{}", "a skin without"},
      {asset, image + R"(png"}], "asset")", R"(mimeType is "png")"},
      {asset, nested(200000), "nested too deeply"},
      {end, chain(100000, ""), "more than 250 deep"},
      {end, chain(300, R"("children": [3])"), "in a ring"},
      {times, R"("count": 1, "type": "MAT4")", "fewer inverseBindMatrices than joints"},
      {times, R"("count": 2, "type": "VEC4")", "fewer inverseBindMatrices than joints"},
      {asset, R"("extensionsRequired": ["KHR_mesh_quantization"], "asset")",
       "needs KHR_mesh_quantization, which is not read"},
      {R"("bufferView": 0, "componentType": 5126)", R"("bufferView": 0, "componentType": 5122)",
       "states its POSITION in whole numbers"},
      {R"("bufferView": 2, "componentType": 5126)", R"("bufferView": 2, "componentType": 5122)",
       "states its output in whole numbers"},
      {R"("byteLength": 256)", R"("byteLength": 0)", "out of range"},
      {"moving.bin", "data:application/octet-stream;base64,", "expected 256 bytes, but found 0"},
      {R"("target": {"node": 2)", R"("target": {"node": 7)", "out of bounds"},
      {R"("children": [1, 2])", R"("children": [1, 0])", "in a ring"},
  };
  for (const auto& [before, after, fault] : broken)
    EXPECT_NE(complaint_of(before, after).find(fault), std::string::npos) << fault;
}

TEST_F(ModelFile, RefusesAGltfThatIsNotFinite) {
  const std::string path = write_moving(true);
  std::fstream file(folder_ / "moving.bin", std::ios::in | std::ios::out | std::ios::binary);
  const float nan = std::nanf("");
  file.seekp(60).write(reinterpret_cast<const char*>(&nan), sizeof nan);  // in the second place
  file.close();
  EXPECT_NE(complaint(path).find("no finite place"), std::string::npos);
}

TEST_F(ModelFile, RefusesABinaryGltfThatIsNotWhole) {
  const std::string json = R"({"asset": {"version": "2.0"}, "skins": [{"joints": []}]})";
  const auto file = [&](std::uint32_t length, std::size_t kept) {
    const std::uint32_t numbers[] = {2, static_cast<std::uint32_t>(20 + json.size()), length};
    std::string bytes = "glTF" + std::string(reinterpret_cast<const char*>(numbers), 12) + "JSON";
    return complaint(write("m.glb", (bytes + json).substr(0, kept)));
  };
  const auto length = static_cast<std::uint32_t>(json.size());
  EXPECT_NE(file(length, 1000).find("a skin without inverseBindMatrices"), std::string::npos);
  EXPECT_NE(file(~0u, 1000).find("breaks off"), std::string::npos);  // assimp alone: 4 GB, slowly
  for (const std::size_t kept : {4u, 19u, 20u, 40u})
    EXPECT_NE(file(length, kept).find("breaks off"), std::string::npos) << kept;
}

TEST_F(ModelFile, SaysInOneLineWhatIsWrong) {
  EXPECT_NE(complaint((folder_ / "none.obj").string()).find("no such"), std::string::npos);
  EXPECT_NE(complaint(write("broken.gltf", "{\"asset\": {\"version\": \"2.0\"}, \"meshes\": [")),
            "");
  EXPECT_NE(
      complaint(write("hollow.gltf",
                      "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"uri\":\"gone.bin\","
                      "\"byteLength\":36}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],"
                      "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,"
                      "\"type\":\"VEC3\"}],\"meshes\":[{\"primitives\":[{\"attributes\":"
                      "{\"POSITION\":0}}]}],\"nodes\":[{\"mesh\":0}],\"scenes\":[{\"nodes\":"
                      "[0]}],\"scene\":0}")),
      "");
  EXPECT_NE(complaint(write("text.obj", "this is no model\n")), "");
  EXPECT_NE(complaint(write("points.obj", "v 0 0 0\nv 1 0 0\n")), "");
  EXPECT_NE(complaint(write("empty.glb", "")), "");
  EXPECT_NE(complaint(folder_.string()), "");
  write("m.mtl", "newmtl skin\nmap_Kd gone.png\n");
  EXPECT_NE(complaint(write("m.obj",
                            "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\n"
                            "vt 1 1\nusemtl skin\nf 1/1 2/2 3/3\n"))
                .find("gone.png"),
            std::string::npos);
  write("gone.png", "\x89PNG\r\n\x1a\n and nothing more");
  EXPECT_NE(complaint((folder_ / "m.obj").string()).find("gone.png"), std::string::npos);
}

}  // namespace
}  // namespace handyar::render
