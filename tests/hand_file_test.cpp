// SPDX-License-Identifier: MIT
#include "handyar/io/hand_file.hpp"

#include <initializer_list>
#include <string>

#include "handyar/io/pending_file.hpp"
#include "handyar/io/sample.hpp"
#include "io_files.hpp"

namespace handyar::io {
namespace {

std::string hand_text() { return read_text(data_file("sample/hand.json")); }

TEST_F(IoTest, HandIsReadBackAsWritten) {
  HandModel hand = average_adult_hand().for_layout(Layout::thumb_left);
  hand.source = HandSource::checkerboard;
  hand.rms_px = 1.0 / 3.0;
  hand.tips_sigma_m.setZero();
  write_hand(path("1.json"), hand);
  HandModel read = read_hand(path("1.json"));
  EXPECT_EQ(read.tips_m, hand.tips_m);
  EXPECT_EQ(read.layout, hand.layout);
  EXPECT_EQ(read.source, hand.source);
  EXPECT_EQ(read.rms_px, hand.rms_px);
  EXPECT_EQ(read.thickness_m, hand.thickness_m);
  EXPECT_FALSE(read.figure);

  hand.tips_sigma_m.setConstant(0.001);
  write_hand(path("2.json"), hand);
  EXPECT_EQ(read_hand(path("2.json")).tips_sigma_m, hand.tips_sigma_m);

  hand.figure = FigureEstimate{};
  hand.figure->mean.setRandom();
  hand.figure->covariance *= 0.25;
  hand.figure->covariance(2, 5) = hand.figure->covariance(5, 2) = 0.1;
  write_hand(path("4.json"), hand);
  EXPECT_NE(read_text(path("4.json")).find("\"version\": 4"), std::string::npos);
  read = read_hand(path("4.json"));
  ASSERT_TRUE(read.figure);
  EXPECT_EQ(read.figure->mean, hand.figure->mean);
  EXPECT_EQ(read.figure->covariance, hand.figure->covariance);
  hand.figure->covariance(0, 0) = -1;
  EXPECT_NE(fault_of([&] { parse_hand(format_hand(hand), "h.json"); }).find("h.json: figure"),
            std::string::npos);
}

TEST_F(IoTest, FaultyHandFilesAreRefusedByField) {
  const struct {
    const char *what, *by, *fault;
  } cases[] = {
      {"\"little\"", "\"pinky\"", "tips_m: there is no pinky on a hand"},
      {"handyar-hand", "hand", "format is not handyar-hand"},
      {"\"version\": 1", "\"version\": 5", "version 5 is not known, only 1 to 4"},
      {"\"version\": 1", "\"version\": 0", "version 0 is not known, only 1 to 4"},
      {"\"version\": 1", "\"version\": 1.5", "version is not a whole number"},
      {"0.093328608", "93.328608", "tips_m: thumb is too far off: the unit is the metre"},
      {"0.093328608", "\"wide\", 0.09", "tips_m: thumb is not [x, y, z]"},
      {"0.093328608", "null, \"", "is not valid JSON"},
      {"0.093328608", "1e999, 0", "is not valid JSON"},
      {"-0.063423204", "0.063423204", "tips_m: thumb and little finger are 46 mm apart"},
      {"thumb_right", "left", "layout is neither thumb_right nor thumb_left"},
      {"thumb_right", "thumb_left", "layout is thumb_left, but the thumb"},
      {"\"truth\"", "\"guess\"", "source is none of checkerboard, default, self, truth"},
      {"\"source\"", "\"origin\"", "source is missing"},
      {"\"rms_px\": 0.0", "\"rms_px\": -1", "rms_px is beyond reason"},
      {"\"thickness_m\": 0.005", "\"thickness_m\": \"5 mm\"", "thickness_m is not a number"},
      {"-0.002473863", "0.4", "tips_m: thumb is 320 mm off the plane of the others"},
  };
  for (const auto& c : cases) {
    const std::string text = replaced(hand_text(), c.what, c.by);
    const std::string fault = fault_of([&] { parse_hand(text, "h.json"); });
    EXPECT_EQ(fault.rfind(std::string("h.json: ") + c.fault, 0), 0u) << fault;
  }
  EXPECT_EQ(fault_of([&] { parse_hand(hand_text() + std::string(1 << 16, ' '), "h.json"); }),
            "h.json: is larger than 64 KiB: not a hand file");
  std::string swapped = replaced(hand_text(), "\"index\"", "\"?\"");
  swapped = replaced(replaced(swapped, "\"ring\"", "\"index\""), "\"?\"", "\"ring\"");
  EXPECT_EQ(fault_of([&] { parse_hand(swapped, "h.json"); }),
            "h.json: tips_m: the fingers do not lie in order from thumb to little");
  HandModel line = parse_hand(hand_text(), "h.json");
  for (int i = 0; i < kFingerCount; ++i) line.tips_m.col(i) << 0.08 - 0.04 * i, 0, 0;
  EXPECT_EQ(fault_of([&] { parse_hand(format_hand(line), "h.json"); }),
            "h.json: tips_m: the fingers do not lie in order from thumb to little");
  std::string four = hand_text();
  const auto at = four.find(",\n  \"little\"");
  ASSERT_NE(at, std::string::npos);
  four.erase(at, four.find(']', at) + 1 - at);
  EXPECT_EQ(fault_of([&] { parse_hand(four, "h.json"); }), "h.json: tips_m: little is missing");
  for (const std::string& text :
       std::initializer_list<std::string>{"", "[]", "7", "{", "{\"format\": 1}", "\"\\u0000\""}) {
    EXPECT_NE(fault_of([&] { parse_hand(text, "h.json"); }), "") << text;
  }
}

}  // namespace
}  // namespace handyar::io
