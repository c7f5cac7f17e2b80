// SPDX-License-Identifier: MIT
#include "handyar/io/camera_file.hpp"

#include <initializer_list>
#include <string>

#include "handyar/io/pending_file.hpp"
#include "handyar/io/sample.hpp"
#include "io_files.hpp"

namespace handyar::io {
namespace {

std::string camera_text() { return read_text(data_file("sample/camera.yml")); }

std::string repeated(const std::string& text, int times) {
  std::string all;
  for (int i = 0; i < times; ++i) all += text;
  return all;
}

TEST_F(IoTest, CameraIsReadBackAsWritten) {
  Camera camera = Camera::from_field_of_view(1280, 720);
  camera.fy_px = 1111.0 / 3.0;
  camera.distortion = {0.1, -0.2, 1e-5, 0, 12.5};
  camera.readout_s = 0.025;
  write_camera(path("camera.yml"), camera);
  const Camera read = read_camera(path("camera.yml"));
  EXPECT_EQ(read.width_px, 1280);
  EXPECT_EQ(read.height_px, 720);
  EXPECT_EQ(read.fx_px, camera.fx_px);
  EXPECT_EQ(read.fy_px, camera.fy_px);
  EXPECT_EQ(read.cx_px, camera.cx_px);
  EXPECT_EQ(read.cy_px, camera.cy_px);
  EXPECT_EQ(read.distortion, camera.distortion);
  EXPECT_EQ(read.readout_s, 0.025);
  EXPECT_TRUE(read.assumed) << "an assumed camera does not become a calibrated one in a file";
  camera.assumed = false;
  write_camera(path("camera.yml"), camera);
  EXPECT_FALSE(read_camera(path("camera.yml")).assumed);
  EXPECT_EQ(files(), 1u);
}

TEST_F(IoTest, CameraFileMayBeginWithAByteOrderMark) {
  EXPECT_EQ(parse_camera("\xef\xbb\xbf" + camera_text(), "c.yml").width_px, 640);
}

TEST_F(IoTest, RosCameraFileIsRead) {
  const Camera camera = parse_camera(
      "image_width: 640\nimage_height: 480\ncamera_name: cam\n"
      "camera_matrix:\n  rows: 3\n  cols: 3\n  data: [600, 0, 320.5, 0, 601, 240, 0, 0, 1]\n"
      "distortion_model: plumb_bob\n"
      "distortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [0.1, 0, 0, 0, 0]\n",
      "ros.yaml");
  EXPECT_EQ(camera.fx_px, 600);
  EXPECT_EQ(camera.cx_px, 320.5);
  EXPECT_EQ(camera.distortion[0], 0.1);
}

TEST_F(IoTest, FaultyCameraFilesAreRefusedByField) {
  const struct {
    const char *what, *by, *fault;
  } cases[] = {
      {"[ 618.0", "[ .nan", "camera_matrix: number 1 is not finite"},
      {"[ 618.0", "[ .Inf", "camera_matrix: number 1 is not finite"},
      {"[ 618.0", "[ nan", "camera_matrix: number 1 is not a number"},
      {"[ 618.0", "[ -618.0", "camera_matrix: a focal length is not positive"},
      {"[ 618.0", "[ 0.618", "camera_matrix: a focal length does not fit the picture's size"},
      {"[ 618.0, 0.0", "[ 618.0, 3.0", "camera_matrix is not of the form fx 0 cx, 0 fy cy, 0 0 1"},
      {"322.38", "3223.8", "camera_matrix: the principal point is outside the picture"},
      {"cols: 3", "cols: 4", "camera_matrix: rows, cols and the count of its numbers disagree"},
      {"image_width: 640", "image_width: 0", "image_width must be a whole number from 1 to 65536"},
      {"image_width: 640", "width: 640", "image_width is missing"},
      {"image_height: 480", "image_height: tall",
       "image_height must be a whole number from 1 to 65536"},
      {"distortion_coefficients", "distortion", "distortion_coefficients is missing"},
      {"[ 0.0, 0.0, 0.0, 0.0, 0.0 ]", "[ 0.0, 0.0, .nan, 0.0, 0.0 ]",
       "distortion_coefficients: number 3 is not finite"},
      {"[ 0.0, 0.0, 0.0, 0.0, 0.0 ]", "[ 0.0, 0.0, 50.0, 50.0, 0.0 ]",
       "distortion_coefficients fold the picture over itself"},
      {"[ 0.0, 0.0, 0.0, 0.0, 0.0 ]", "[ -3.0, 0.0, 0.0, 0.0, 0.0 ]",
       "distortion_coefficients fold the picture over itself"},
      {"[ 0.0, 0.0, 0.0, 0.0, 0.0 ]", "[ -0.41, 0.19, 0.001, -0.002, -0.05 ]", ""},
      {"cols: 5\n   dt: d\n   data: [ 0.0, 0.0, ", "cols: 3\n   dt: d\n   data: [ ",
       "distortion_coefficients: 4, 5 or 8 numbers are expected, not 3"},
      {"cols: 5\n   dt: d\n   data: [ ", "cols: 8\n   dt: d\n   data: [ 0.0, 0.0, 0.0, ", ""},
      {"cols: 5\n   dt: d\n   data: [ 0.0, 0.0, 0.0, 0.0, 0.0",
       "cols: 8\n   dt: d\n   data: [ 0., 0., 0., 0., 0., 0.1, 0., 0.",
       "distortion_coefficients: k4, k5, k6 are not supported, only zero"},
      {"image_width", "readout_s: 0.02\nimage_width", ""},
      {"image_width", "readout_s: 25\nimage_width", "readout_s must be a number from 0 to 0.1"},
      {"image_width", "readout_s: .nan\nimage_width", "readout_s must be a number from 0 to 0.1"},
      {"image_width", "readout_s: all\nimage_width", "readout_s must be a number from 0 to 0.1"},
      {"image_width", "assumed: 1\nimage_width", ""},
      {"image_width", "assumed: yes\nimage_width", "assumed must be 0 or 1"},
      {"image_width", "assumed: 2\nimage_width", "assumed must be 0 or 1"},
  };
  for (const auto& c : cases) {
    const std::string text = replaced(camera_text(), c.what, c.by);
    const std::string fault = fault_of([&] { parse_camera(text, "c.yml"); });
    EXPECT_EQ(fault, *c.fault ? std::string("c.yml: ") + c.fault : "") << c.by;
  }
  for (const std::string& text : std::initializer_list<std::string>{
           "", "hello", "%YAML:1.0\n---\n- a\n", "{", "\x01\x02\xff", "%YAML:1.0\n---\n   :dt ls",
           "%YAML:1.0\n---\nimage_width: [", "<?xml version=\"1.0\"?>",
           // found by fuzzing: OpenCV 4.6 alone never returns from these
           "%YAML:1.0\n---------%YAML:1.0\n---\n--/---ig. :---a_m,", "a: 1\n-x",
           "\n \xdb%YAML:1.0\n-\xa6-\nimage_width: 640\nimage_height: 480\n"
           "camera_matrix: !!opencv\xb6:-.-mia",
           // OpenCV alone runs out of stack
           "a: " + std::string(200000, '['), "{\"a\": " + std::string(200000, '['),
           "a:\n  " + repeated("- ", 200000), "a:\n  " + std::string(200000, '-') + "x",
           repeated("a: ", 200000) + "x", "a: " + repeated("{b: ", 200000),
           "<?xml version=\"1.0\"?>\n<opencv_storage>" + repeated("<a>", 200000)}) {
    EXPECT_NE(fault_of([&] { parse_camera(text, "c.yml"); }), "") << text.substr(0, 100);
  }
  EXPECT_EQ(fault_of([] { parse_camera("a: 1\nb: [ 1,\nc: 2 ]\n", "c.yml"); }),
            "c.yml: is not a camera file (YAML): line 3: Incorrect indentation");
}

TEST_F(IoTest, CameraFitsOtherSizesOfTheSameShapeOnly) {
  const Camera assumed = Camera::from_field_of_view(1280, 960);
  EXPECT_EQ(camera_for_size(assumed, 960, 1280, "c.yml").fx_px, assumed.fx_px);
  Camera camera = assumed;
  camera.assumed = false;
  const Camera half = camera_for_size(camera, 640, 480, "c.yml");
  EXPECT_EQ(half.width_px, 640);
  EXPECT_NEAR(half.fx_px, camera.fx_px / 2, 1e-9);
  EXPECT_EQ(fault_of([&] { camera_for_size(camera, 1280, 720, "c.yml"); }),
            "c.yml: is for pictures of 1280x960 pixels, the input has 1280x720: another shape, so "
            "it cannot be scaled to it");
}

}  // namespace
}  // namespace handyar::io
