// SPDX-License-Identifier: MIT
#include "frame.hpp"

#include <array>
#include <string_view>

namespace handyar::python {
namespace {

struct Named {
  std::string_view name;
  PixelFormat format;
  PixelFormat reversed;  ///< the same bytes when the channels are counted from the last one
};
constexpr std::array<Named, 4> kFormats = {{{"bgr", PixelFormat::bgr, PixelFormat::rgb},
                                            {"rgb", PixelFormat::rgb, PixelFormat::bgr},
                                            {"bgra", PixelFormat::bgra, PixelFormat::bgra},
                                            {"rgba", PixelFormat::rgba, PixelFormat::rgba}}};

const Named& named(const std::string& format) {
  for (const Named& known : kFormats)
    if (known.name == format) return known;
  throw py::value_error("format: 'bgr', 'rgb', 'bgra' or 'rgba' is wanted, not '" + format + "'");
}

std::string text(const py::handle& object) { return py::str(object); }

}  // namespace

ImageView view_of(const py::object& frame, const std::string& format) {
  if (!py::isinstance<py::array>(frame)) {
    throw py::type_error("frame: a numpy array is wanted, not " +
                         text(py::type::of(frame).attr("__name__")));
  }
  const auto pixels = py::reinterpret_borrow<py::array>(frame);
  if (!py::isinstance<py::array_t<std::uint8_t>>(frame))
    throw py::type_error("frame: numbers of type uint8 are wanted, not " + text(pixels.dtype()));
  if (pixels.ndim() == 2 || (pixels.ndim() == 3 && pixels.shape(2) == 1))
    throw py::value_error(describe(FrameStatus::gray_unsupported));

  const Named& known = named(format);
  const auto channels = static_cast<py::ssize_t>(format.size());
  const std::string wanted =
      "(height, width, " + std::to_string(channels) + ") for format '" + format + "'";
  if (pixels.ndim() != 3 || pixels.shape(2) != channels) {
    throw py::value_error("frame: shape " + text(frame.attr("shape")) + " is not " + wanted);
  }
  const bool reversed = channels == 3 && pixels.strides(2) == -1;
  if (pixels.strides(1) != channels || !(reversed || pixels.strides(2) == 1)) {
    throw py::value_error(
        "frame: the pixels of a row do not lie one after the other in memory; "
        "numpy.ascontiguousarray(frame) helps");
  }
  constexpr py::ssize_t kMost = 1 << 20;  // larger ones are refused by their size anyway
  ImageView view;
  view.data = static_cast<const std::uint8_t*>(pixels.data()) - (reversed ? channels - 1 : 0);
  view.width_px = static_cast<int>(std::min(pixels.shape(1), kMost));
  view.height_px = static_cast<int>(std::min(pixels.shape(0), kMost));
  view.stride_bytes = pixels.strides(0);
  view.format = reversed ? known.reversed : known.format;
  if (const FrameStatus status = check(view); status != FrameStatus::ok)
    throw py::value_error("frame of " + std::to_string(view.width_px) + "x" +
                          std::to_string(view.height_px) + " pixels: " + describe(status));
  return view;
}

}  // namespace handyar::python
