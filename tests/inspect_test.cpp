// SPDX-License-Identifier: MIT
// `handyar inspect` as its users meet it.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "temporary_folder.hpp"

namespace fs = std::filesystem;

namespace handyar {
namespace {

using nlohmann::json;

const std::string kData = HANDYAR_DATA_DIR;
const std::string kClip = kData + "/select/video.mp4 --camera " + kData +
                          "/select/camera.yml --hand " + kData + "/select/hand.json";

std::string contents(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

struct InspectTest : testing::Test {
  const test::TemporaryFolder folder;

  std::string path(const std::string& name) const { return folder / name; }

  int run(const std::string& arguments) const {
    const int status =
        std::system(("XDG_CONFIG_HOME='" + path("config") + "' '" HANDYAR_PROGRAM "' inspect " +
                     arguments + " >" + path("stdout") + " 2>" + path("stderr"))
                        .c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  /// Runs the clip with a faulty scene and gives what is said about it.
  std::string complaint(const json& scene) const {
    std::ofstream(path("scene.json")) << scene;
    const std::string events = path("events.jsonl");
    EXPECT_EQ(run(kClip + " --scene " + path("scene.json") + " --events " + events), 1);
    EXPECT_FALSE(fs::exists(events));
    const std::string said = contents(path("stderr"));
    EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1) << said;
    return said;
  }
};

TEST_F(InspectTest, TheHandTakesTheMiddleObjectAndGivesItBack) {
  ASSERT_EQ(run(kClip + " --scene " + kData + "/scene_select.json --events " + path("e.jsonl")), 0)
      << contents(path("stderr"));
  std::istringstream stream(contents(path("e.jsonl")));
  std::vector<json> events;
  for (std::string line; std::getline(stream, line);) events.push_back(json::parse(line));
  ASSERT_EQ(events.size(), 3u);
  EXPECT_EQ(contents(path("stdout")).find("no marker"), std::string::npos);
  const struct {
    const char* event;
    int first, last;  // frames that the rendered truth allows, with a second around it
  } expected[] = {{"selected", 45, 112}, {"attached", 45, 138}, {"released", 256, 304}};
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(events[i]["event"], expected[i].event);
    EXPECT_EQ(events[i]["object"], "green teapot");
    EXPECT_GE(events[i]["frame"], expected[i].first);
    EXPECT_LE(events[i]["frame"], expected[i].last);
    EXPECT_NEAR(events[i]["time_s"], events[i]["frame"].get<double>() / 30, 1e-6);
  }
}

TEST_F(InspectTest, SaysThatNoMarkerWasSeen) {
  const std::string scene = " --scene " + kData + "/scene_select.json";
  ASSERT_EQ(run(kData + "/compare/video.mp4" + scene), 0) << contents(path("stderr"));
  EXPECT_NE(contents(path("stdout")).find("\nno marker of the scene was seen\n"),
            std::string::npos);
}

TEST_F(InspectTest, FaultySceneFilesAreSaidInOneLine) {
  const json scene = json::parse(contents(kData + "/scene_select.json"));
  json s = scene;
  s["objects"][1]["model"] = "gone.obj";
  EXPECT_NE(complaint(s).find("gone.obj"), std::string::npos);
  s = scene;
  s["objects"][1]["marker"]["dictionary"] = "DICT_3X3";
  EXPECT_NE(complaint(s).find("DICT_3X3"), std::string::npos);
  s = scene;
  s["objects"][1]["marker"]["id"] = 3;
  EXPECT_NE(complaint(s).find("already on marker 3"), std::string::npos);
  std::ofstream(path("broken.gltf")) << "{\"asset\":";
  s = scene;
  s["objects"][1]["model"] = "broken.gltf";
  EXPECT_NE(complaint(s).find("broken.gltf"), std::string::npos);
  s = scene;
  s["world"] = {{"map", "desk.map"}};
  s["objects"] = {{{"model", "teapot"}}};
  EXPECT_NE(complaint(s).find("is a scene of a map"), std::string::npos);
}

TEST_F(InspectTest, EventsOfAnEarlierRunStayUntilThereAreOthers) {
  std::ofstream(path("e.jsonl")) << "earlier\n";
  EXPECT_EQ(run(path("gone.mp4") + " --scene " + kData + "/scene_select.json --events " +
                path("e.jsonl")),
            1);
  EXPECT_EQ(contents(path("e.jsonl")), "earlier\n");
}

TEST_F(InspectTest, WrongUsageIsTwo) {
  EXPECT_EQ(run(kClip), 2);
  EXPECT_EQ(run("--scene " + kData + "/scene_select.json"), 2);
  EXPECT_EQ(run(kClip + " --scene " + path("s") + " --events " + path("s")), 2);
  json scene = json::parse(contents(kData + "/scene_select.json"));
  scene["objects"][1]["model"] = "model.obj";
  std::ofstream(path("scene.json")) << scene;
  std::ofstream(path("model.obj")) << "v 0 0 0\n";
  EXPECT_EQ(run(kClip + " --scene " + path("scene.json") + " --events " + path("model.obj")), 2);
  EXPECT_EQ(contents(path("model.obj")), "v 0 0 0\n");
}

}  // namespace
}  // namespace handyar
