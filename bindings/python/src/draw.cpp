// SPDX-License-Identifier: MIT
// handyar.draw: the command line's annotation on pictures of numpy.
#include <pybind11/pybind11.h>

#include <opencv2/imgproc.hpp>

#include "arrays.hpp"
#include "frame.hpp"
#include "handyar/opencv/annotate.hpp"
#include "tracker.hpp"

namespace handyar::python {
namespace {

using namespace pybind11::literals;

// Lets `draw` work on a picture as BGR, in place.
template <class Draw>
void on_picture(const py::object& picture, const std::string& format, Draw draw) {
  if (format != "bgr" && format != "rgb")
    throw py::value_error("format: 'bgr' or 'rgb' is wanted, not '" + format + "'");
  const ImageView view = view_of(picture, format);
  if (!py::cast<py::array>(picture).writeable())
    throw py::value_error("picture: it cannot be written on; picture.copy() can");
  if (view.stride_bytes < 0) {
    throw py::value_error(
        "picture: its rows lie upside down in memory; numpy.ascontiguousarray(picture) helps");
  }
  const py::gil_scoped_release release;
  cv::Mat pixels(view.height_px, view.width_px, CV_8UC3, const_cast<std::uint8_t*>(view.data),
                 static_cast<std::size_t>(view.stride_bytes));
  const bool rgb = view.format == PixelFormat::rgb;
  if (rgb) cv::cvtColor(pixels, pixels, cv::COLOR_RGB2BGR);
  draw(pixels);
  if (rgb) cv::cvtColor(pixels, pixels, cv::COLOR_BGR2RGB);
}

}  // namespace
}  // namespace handyar::python

PYBIND11_MODULE(draw, m) {
  using namespace handyar::python;
  using handyar::Camera, handyar::TrackResult;
  py::module_::import("handyar._core");
  m.doc() = R"(What the tracker found, drawn on a picture.

Pictures are uint8, shape (height, width, 3), and are drawn on in place; `format` is the order of
their channels, 'bgr' or 'rgb'. Sizes of lines and letters follow the picture's.)";

  m.def(
      "annotate",
      [](const py::object& picture, Tracker& tracker, const TrackResult& result,
         const std::string& format, bool mirrored) {
        on_picture(picture, format, [&](cv::Mat& bgr) {
          tracker.alone([&](const TrackerState& t) {
            handyar::annotate(bgr, t.tracker.mask(), t.camera.scaled_to(bgr.cols, bgr.rows), result,
                              mirrored);
          });
        });
      },
      "picture"_a, "tracker"_a, "result"_a, "format"_a = "bgr", "mirrored"_a = false,
      R"(All of it: outline, axes, fingertips, and a line with state, layout and distance.

tracker, result: those of this frame. mirrored: the picture will be mirrored afterwards, as one sees
oneself, so words are written from right to left.)");
  m.def(
      "outline",
      [](const py::object& picture, Tracker& tracker, const std::string& format) {
        on_picture(picture, format, [&](cv::Mat& bgr) {
          tracker.alone(
              [&](const TrackerState& t) { handyar::draw_contour(bgr, t.tracker.mask()); });
        });
      },
      "picture"_a, "tracker"_a, "format"_a = "bgr", "The hand's outline in the last frame.");
  m.def(
      "tips",
      [](const py::object& picture, const TrackResult& result, const std::string& format) {
        on_picture(picture, format, [&](cv::Mat& bgr) { handyar::draw_tips(bgr, result); });
      },
      "picture"_a, "result"_a, "format"_a = "bgr", "The fingertips with their names.");
  m.def(
      "axes",
      [](const py::object& picture, const Camera& camera, const Numbers& pose,
         const std::string& format) {
        const Eigen::Isometry3d T_camera_hand = isometry_of(pose, "pose");
        on_picture(picture, format,
                   [&](cv::Mat& bgr) { handyar::draw_axes(bgr, camera, T_camera_hand); });
      },
      "picture"_a, "camera"_a, "pose"_a, "format"_a = "bgr",
      "The axes of the hand frame, 40 mm long: x red, y green, z blue. camera: of this picture's "
      "size. pose: T_camera_hand, shape (4, 4), metres.");
}
