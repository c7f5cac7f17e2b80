// SPDX-License-Identifier: MIT
#include "handyar/render/scene.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "handyar/io/error.hpp"
#include "temporary_folder.hpp"

namespace handyar::render {
namespace {

using nlohmann::json;

json marker(int id) { return {{"dictionary", "DICT_4X4_50"}, {"id", id}, {"size_mm", 70}}; }

json two_objects() {
  return {{"format", "handyar-scene"},
          {"version", 1},
          {"objects",
           {{{"name", "a"}, {"marker", marker(3)}, {"model", "teapot"}, {"colour", "#ff8000"}},
            {{"name", "b"}, {"marker", marker(4)}, {"model", "shelf/cup.obj"}}}}};
}

/// What the reader says of a scene; empty when it has nothing to say.
std::string complaint(const std::string& text) {
  try {
    parse_scene(text, "rooms/scene.json");
  } catch (const io::Error& e) {
    return e.what();
  }
  return "";
}
std::string complaint(const json& scene) { return complaint(scene.dump()); }

void expect_complaint(const json& scene, const std::string& part) {
  const std::string said = complaint(scene);
  EXPECT_EQ(said.find("rooms/scene.json: "), 0u) << said;
  EXPECT_NE(said.find(part), std::string::npos) << said;
  EXPECT_EQ(said.find('\n'), std::string::npos) << said;
}

TEST(Scene, ReadsObjectsAndTheirMarkers) {
  json in = two_objects();
  in["objects"][0]["size_mm"] = 85;
  in["objects"][0]["attach"] = "index_tip";
  in["objects"][0]["pose"] = {{"position_mm", {10, 20, 30}}, {"rotation_deg", {90, 0, 90}}};
  const Scene scene = parse_scene(in.dump(), "rooms/scene.json");
  ASSERT_EQ(scene.objects.size(), 2u);
  ASSERT_EQ(scene.markers.size(), 2u);
  EXPECT_EQ(scene.markers[1].id, 4);
  EXPECT_DOUBLE_EQ(scene.markers[0].size_m, 0.07);
  EXPECT_FALSE(scene.markers[0].T_world_marker);
  const SceneObject& a = scene.objects[0];
  EXPECT_EQ(a.model, "teapot");
  EXPECT_DOUBLE_EQ(a.size_m, 0.085);
  EXPECT_TRUE(a.colour.isApprox(Eigen::Vector3f(1, 128 / 255.0f, 0), 1e-5f));
  EXPECT_EQ(a.attachment, Attachment::index_tip);
  EXPECT_EQ(scene.objects[1].attachment, Attachment::face);
  EXPECT_EQ(scene.objects[1].model, "rooms/shelf/cup.obj");
  // About x first: y goes to z. Then about z, which leaves it there; and x goes to y.
  EXPECT_TRUE((a.T_marker_object.linear() * Eigen::Vector3d::UnitY())
                  .isApprox(Eigen::Vector3d::UnitZ(), 1e-9));
  EXPECT_TRUE((a.T_marker_object.linear() * Eigen::Vector3d::UnitX())
                  .isApprox(Eigen::Vector3d::UnitY(), 1e-9));
  EXPECT_TRUE(a.T_marker_object.translation().isApprox(Eigen::Vector3d(0.01, 0.02, 0.03), 1e-12));
}

TEST(Scene, MarkersOrABoardDefineTheWorld) {
  json in = two_objects();
  in["world"] = {{"markers", {marker(3), marker(4)}}};
  in["world"]["markers"][1]["pose"] = {{"position_mm", {200, 0, 0}}};
  in["objects"][1].erase("marker");
  const Scene several = parse_scene(in.dump(), "s.json");
  EXPECT_EQ(several.objects[0].marker, 0);
  EXPECT_EQ(several.objects[1].marker, -1);
  EXPECT_DOUBLE_EQ(several.markers[1].T_world_marker->translation().x(), 0.2);

  in["world"] = {{"board",
                  {{"dictionary", "DICT_APRILTAG_36h11"},
                   {"columns", 3},
                   {"rows", 2},
                   {"size_mm", 30},
                   {"gap_mm", 10},
                   {"id", 5}}}};
  in["objects"][0]["marker"] = {{"dictionary", "DICT_APRILTAG_36h11"}, {"id", 10}, {"size_mm", 30}};
  const Scene board = parse_scene(in.dump(), "s.json");
  ASSERT_EQ(board.markers.size(), 6u);
  EXPECT_EQ(board.objects[0].marker, 5);
  EXPECT_TRUE(board.markers[5].T_world_marker->translation().isApprox(
      Eigen::Vector3d(0.04, -0.02, 0), 1e-12));
}

TEST(Scene, OfAMapIsWrittenAndReadAgain) {
  Scene scene;
  SceneObject cup;
  cup.name = "a \"cup\"";
  cup.size_m = 0.12;
  cup.colour = {1, 0.2f, 0};
  cup.attachment = Attachment::palm;
  cup.T_marker_object.linear() =
      Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
  cup.T_marker_object.translation() = Eigen::Vector3d(0.1, -0.2, 0.03);
  SceneObject bunny;
  bunny.name = "bunny";
  bunny.model = "bunny";
  scene.objects = {cup, bunny};

  const test::TemporaryFolder folder;
  scene.map = folder / "maps/room.map";
  scene.objects[0].model = folder / "cup.obj";
  write_scene(folder / "desk.json", scene);
  const Scene read = read_scene(folder / "desk.json");

  EXPECT_EQ(read.map, scene.map);
  EXPECT_TRUE(read.markers.empty());
  ASSERT_EQ(read.objects.size(), 2u);
  const SceneObject& again = read.objects[0];
  EXPECT_EQ(again.name, cup.name);
  EXPECT_EQ(again.model, folder / "cup.obj");
  EXPECT_EQ(again.attachment, Attachment::palm);
  EXPECT_NEAR(again.size_m, 0.12, 1e-6);
  EXPECT_NEAR((again.colour - cup.colour).norm(), 0, 0.005);
  EXPECT_TRUE(again.T_marker_object.isApprox(cup.T_marker_object, 1e-4));
  EXPECT_EQ(read.objects[1].model, "bunny");
  EXPECT_TRUE(read.objects[1].T_marker_object.isApprox(Eigen::Isometry3d::Identity()));
}

TEST(Scene, OfAMapMayStillBeEmpty) {
  const test::TemporaryFolder folder;
  const std::string path = folder / "scene.json";
  Scene scene;
  scene.map = folder / "desk.map";
  write_scene(path, scene);
  EXPECT_TRUE(read_scene(path).objects.empty());
  scene.objects.emplace_back().model = folder / "caf\xe9.obj";
  EXPECT_THROW(write_scene(path, scene), io::Error);
}

TEST(Scene, SaysInOneLineWhatIsWrong) {
  EXPECT_EQ(complaint(two_objects()), "");
  EXPECT_NE(complaint(std::string("{\"objects\": [")).find("json: is not valid JSON: parse error"),
            std::string::npos);
  expect_complaint(json::array(), "is not a scene");
  expect_complaint({{"format", "handyar-hand"}}, "format");

  const auto with = [](auto change) {
    json scene = two_objects();
    change(scene["objects"][1]);
    return scene;
  };
  expect_complaint(with([](json& o) { o["marker"]["dictionary"] = "DICT_9X9"; }),
                   "object 2: unknown marker dictionary \"DICT_9X9\"");
  expect_complaint(with([](json& o) { o["marker"]["id"] = 3; }), "\"a\" is already on marker 3");
  expect_complaint(with([](json& o) { o["marker"].erase("size_mm"); }), "\"size_mm\" is missing");
  expect_complaint(with([](json& o) { o.erase("marker"); }), "\"marker\" is missing");
  expect_complaint(with([](json& o) { o.erase("model"); }), "\"model\" is missing");
  expect_complaint(with([](json& o) { o["colour"] = "red"; }), "#rrggbb");
  expect_complaint(with([](json& o) { o["attach"] = "elbow"; }), "no place of the hand");
  expect_complaint(with([](json& o) { o["size_mm"] = -3; }), "size_mm");
  expect_complaint(with([](json& o) { o["size_mm"] = "big"; }), "size_mm");
  expect_complaint(with([](json& o) { o["pose"] = {{"position_mm", {1, 2}}}; }), "position_mm");
  expect_complaint(with([](json& o) {
                     o["pose"] = {{"position_mm", {1e9, 0, 0}}};
                   }),
                   "object 2: \"position_mm\": 1000000000.0 is not from -1e6 to 1e6");
  expect_complaint(with([](json& o) { o["name"] = "a"; }), "used twice");
  expect_complaint(with([](json& o) { o = 7; }), "object 2");
  expect_complaint(with([](json& o) { o["marker"]["id"] = 50; }),
                   "object 2: \"id\" is not a number from 0 to 49");
  for (const char* colour : {"#-1-1-1", "# 1 2 3", "#12345g", "#123456 ", "0123456"})
    expect_complaint(with([&](json& o) { o["colour"] = colour; }), "#rrggbb");
  expect_complaint(with([](json& o) { o["color"] = "#ffffff"; }),
                   "object 2: \"color\" is not known here");
  expect_complaint(with([](json& o) { o["pose"] = {{"positon_mm", {1, 2, 3}}}; }), "positon_mm");
  expect_complaint(with([](json& o) { o["marker"]["pose"] = json::object(); }), "\"pose\"");
  json scene = two_objects();
  scene["wrold"] = json::object();
  expect_complaint(scene, "\"wrold\" is not known here");
  scene = two_objects();
  scene["world"] = {{"board",
                     {{"dictionary", "DICT_4X4_50"},
                      {"columns", 8},
                      {"rows", 6},
                      {"size_mm", 30},
                      {"gap_mm", 10},
                      {"id", 3}}}};
  expect_complaint(scene, "world: the board needs ids up to 50, DICT_4X4_50 has 50");
  expect_complaint({{"format", "handyar-scene"}, {"version", 1}, {"objects", json::array()}},
                   "missing or empty");
  scene["world"]["board"]["id"] = 2;
  scene.erase("objects");
  expect_complaint(scene, "json: \"objects\" is missing");
}

}  // namespace
}  // namespace handyar::render
