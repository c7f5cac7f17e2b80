// SPDX-License-Identifier: MIT
#include <fstream>
#include <iterator>

#include "handyar/io/error.hpp"
#include "tabletop.hpp"
#include "temporary_folder.hpp"

namespace handyar::world {
namespace {

std::string fault_of(const std::string& bytes) {
  try {
    static_cast<void>(parse_map(bytes, "desk.map"));
  } catch (const io::Error& e) {
    return e.what();
  }
  return "";
}

TEST(MapFile, SaysWhatIsWrongWithIt) {
  Tabletop table;
  const test::TemporaryFolder folder;
  const std::string file = folder / "desk.map";
  write_map(file, made_map(table));
  std::ifstream stream(file, std::ios::binary);
  const std::string whole{std::istreambuf_iterator<char>(stream), {}};
  EXPECT_EQ(fault_of(whole), "");
  EXPECT_EQ(fault_of(""), "desk.map: is not a map of handyar");
  EXPECT_EQ(fault_of("{}\n"), "desk.map: is not a map of handyar");
  EXPECT_EQ(fault_of(whole.substr(0, whole.size() - 1)), "desk.map: ends within a picture");
  EXPECT_EQ(fault_of(whole + "x"), "desk.map: has more after its last picture");
  std::string changed = whole;
  changed.replace(changed.find("\"version\":1"), 11, "\"version\":9");
  EXPECT_EQ(fault_of(changed), "desk.map: \"version\" is not 1");
  changed = whole;
  changed.replace(changed.find("\"width_px\":640"), 14, "\"width_px\":960");
  EXPECT_EQ(fault_of(changed), "desk.map: a picture is no PNG of the camera's size");
  changed = whole.substr(0, whole.find('\n'));
  changed.replace(changed.find("\"width_px\":640"), 14, "\"width_px\":8192");
  changed.replace(changed.find("\"height_px\":480"), 15, "\"height_px\":8192");
  changed.replace(changed.find("\"keyframes\":["), 13, "\"keyframes\":[0,0,0,0,0,0,0,");
  EXPECT_EQ(fault_of(changed + '\n'),
            "desk.map: its keyframes are larger than 60 of 4096x2160 pixels");
  EXPECT_EQ(fault_of("{\"format\":\"handyar-map\",\"version\":1}\n"),
            "desk.map: key 'camera' not found");
  changed = whole;
  changed[changed.find("IDAT") + 20] ^= 1;
  testing::internal::CaptureStderr();
  EXPECT_EQ(fault_of(changed), "desk.map: a picture cannot be read");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << "libpng's own words";
  EXPECT_THROW(static_cast<void>(read_map("/nowhere/desk.map")), io::Error);
}

}  // namespace
}  // namespace handyar::world
