// SPDX-License-Identifier: MIT
// `handyar world` as its users meet it.
#include <set>
#include <string>

#include "command_line.hpp"

namespace handyar {
namespace {

// The hand of this clip lies still beside a board, and the camera begins to move.
const std::string kWorldClip =
    kVideo + " --camera " + kData + "/compare/camera.yml --hand " + kData + "/compare/hand.json";

TEST_F(CliTest, AWorldIsWrittenAndFoundAgain) {
  const std::string files = " --scene " + out("desk.json") + " --poses " + out("p.csv");
  const Outcome first = run("world " + kWorldClip + files + " --events " + out("e.jsonl"));
  EXPECT_EQ(first.code, 0) << first.err;
  EXPECT_EQ(first.err, "");
  EXPECT_EQ(left(), (std::set<std::string>{"desk.json", "desk.map", "e.jsonl", "p.csv"}));
  EXPECT_EQ(contents(out("e.jsonl")), "{\"event\":\"world_found\",\"frame\":15,\"time_s\":0.5}\n");
  const std::string rows = contents(out("p.csv")), scene = contents(out("desk.json"));
  EXPECT_EQ(lines(rows), 91);
  EXPECT_NE(rows.find("\n14,0.466667,setting,,"), std::string::npos) << rows;
  EXPECT_NE(rows.find("\n15,0.500000,tracked,0."), std::string::npos) << rows;
  EXPECT_NE(scene.find("\"map\": \"desk.map\""), std::string::npos) << scene;

  const Outcome second = run("world " + kWorldClip + files);
  EXPECT_EQ(second.code, 0) << second.err;
  EXPECT_NE(contents(out("p.csv")).find("\n3,0.100000,tracked,0."), std::string::npos);
  EXPECT_EQ(lines(contents(out("desk.json"))), lines(scene));  // the same object
}

TEST_F(CliTest, BadWorldsAreRefusedInOneLine) {
  const auto refused = [&](const std::string& arguments, const std::string& subject,
                           const std::string& fault) {
    expect_refused(
        kWorldClip + " --poses " + out("p.csv") + " --events " + out("e.jsonl") + arguments,
        subject, fault, "world ");
  };
  write("broken.map", "{\"format\": \"handyar-map\", \"version\": 1}\n");
  write("text.map", "This is a text.\n");
  refused(" --map " + in("broken.map"), in("broken.map"), "camera");
  refused(" --map " + in("text.map"), in("text.map"), "is not a map");
  refused(" --map /proc/desk.map", "/proc/desk.map", "cannot be written");
  refused(" --model " + in("no.obj") + " --video " + out("v.mp4"), in("no.obj"), "no such model");
  expect_refused(kWorldClip + " --map " + out("a.map") + " --model " + in("no.obj"), in("no.obj"),
                 "no such model", "world ");
  refused(" --scene " + kData + "/scene_select.json", kData + "/scene_select.json", "of markers");
  write("desk.json",
        R"({"format": "handyar-scene", "version": 1, "world": {"map": "gone.map"},
            "objects": [{"model": "teapot"}]})");
  refused(" --scene " + in("desk.json"), in("desk.json"), "gone.map is not there");
}

TEST_F(CliTest, AWorldThatNobodySetLeavesNoMap) {
  const Outcome r =
      run("world " + kData + "/wall/video.mp4 --map " + out("a.map") + " --scene " + out("a.json"));
  EXPECT_EQ(r.code, 0) << r.err;
  EXPECT_EQ(r.out.rfind("no world: too little to see around the hand (in ", 0), 0u) << r.out;
  EXPECT_EQ(left(), std::set<std::string>{});
}

}  // namespace
}  // namespace handyar
