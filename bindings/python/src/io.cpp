// SPDX-License-Identifier: MIT
// handyar._io: frames from videos and cameras, and files. handyar.io adds what is plain Python.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>
#include <memory>
#include <variant>

#include "arrays.hpp"
#include "handyar/io/camera_file.hpp"
#include "handyar/io/cameras.hpp"
#include "handyar/io/error.hpp"
#include "handyar/io/frame_source.hpp"
#include "handyar/io/hand_file.hpp"
#include "handyar/io/pose_csv.hpp"
#include "handyar/io/sample.hpp"
#include "shared.hpp"

namespace handyar::python {
namespace {

using namespace pybind11::literals;
using std::filesystem::path;

// The picture itself, not a copy: the array keeps it.
py::array_t<std::uint8_t> array(const cv::Mat& bgr) {
  const py::capsule owner(new cv::Mat(bgr), [](void* p) { delete static_cast<cv::Mat*>(p); });
  return py::array_t<std::uint8_t>({bgr.rows, bgr.cols, bgr.channels()},
                                   {static_cast<py::ssize_t>(bgr.step[0]),
                                    static_cast<py::ssize_t>(bgr.channels()), py::ssize_t{1}},
                                   bgr.data, owner);
}

// File names are bytes; Python has a way of its own to write those that are no text.
py::object text_of(const std::string& bytes) {
  return py::reinterpret_steal<py::object>(PyUnicode_DecodeFSDefault(bytes.c_str()));
}

struct PythonFrame {
  py::array_t<std::uint8_t> bgr;
  double time_s;
  std::int64_t index;
};

struct PythonSource {
  explicit PythonSource(std::unique_ptr<io::FrameSource> source)
      : info(source->info()), frames(std::move(source)) {}

  io::SourceInfo info;
  Shared<std::unique_ptr<io::FrameSource>> frames;
};

PythonFrame next(PythonSource& source) {
  io::Frame frame;  // a new one each time: Python keeps the picture for as long as it likes
  if (!source.frames.use([&](auto& frames) { return frames->read(frame); }))
    throw py::stop_iteration();
  return {array(frame.bgr), frame.time_s, frame.index};
}

void bind_frames(py::module_& m) {
  py::class_<PythonFrame>(m, "Frame", "One picture of an input.")
      .def_readonly("bgr", &PythonFrame::bgr, "uint8, shape (height, width, 3), upright.")
      .def_readonly("time_s", &PythonFrame::time_s,
                    "Seconds since the first frame, strictly increasing.")
      .def_readonly(
          "index", &PythonFrame::index,
          "From 0; a frame that a live camera or a numbered series left out leaves a gap.");

  py::class_<PythonSource>(m, "FrameSource",
                           "Frames one after the other, all of one size; for open_input().")
      .def("__iter__", [](py::object self) { return self; })
      .def("__next__", &next)
      .def_property_readonly(
          "name", [](const PythonSource& s) { return text_of(s.info.name); },
          "As messages call it: the path, or the camera's device.")
      .def_property_readonly(
          "width_px", [](const PythonSource& s) { return s.info.width_px; },
          "Width of every frame.")
      .def_property_readonly(
          "height_px", [](const PythonSource& s) { return s.info.height_px; },
          "Height of every frame.")
      .def_property_readonly(
          "fps", [](const PythonSource& s) { return s.info.fps; }, "Nominal frames a second.")
      .def_property_readonly(
          "frame_count",
          [](const PythonSource& s) {
            return s.info.frame_count > 0 ? std::optional(s.info.frame_count) : std::nullopt;
          },
          "How many frames the file promises; None: unknown or endless.")
      .def_property_readonly(
          "live", [](const PythonSource& s) { return s.info.live; }, "Whether it is a camera.");

  m.def(
      "open_input",
      [](const std::variant<int, path>& input, std::optional<std::pair<int, int>> size_px,
         double fps, bool lock) {
        io::CameraSettings settings;
        if (size_px) std::tie(settings.width_px, settings.height_px) = *size_px;
        settings.fps = fps;
        settings.lock = lock;
        const int* number = std::get_if<int>(&input);
        const std::string name =
            number != nullptr ? std::to_string(*number) : std::get<path>(input).string();
        const py::gil_scoped_release release;
        return std::make_unique<PythonSource>(io::open_input(name, settings));
      },
      "input"_a, py::kw_only(), "size_px"_a = py::none(), "fps"_a = 0.0, "lock"_a = false,
      R"(Opens a video file, a picture, a numbered series of pictures ('frames/%04d.png'), a camera
(0, '/dev/video0', its name or a part of it), or 'sample', the shipped clip:

    for frame in handyar.io.open_input("sample"):
        result = tracker.process(frame.bgr, frame.time_s)

size_px: width and height, fps: frames a second that a camera is asked for. lock: exposure, white
balance and focus stay as they are after the first second. Raises Error.)");

  py::class_<io::CameraInfo>(m, "CameraInfo", "A camera of this machine.")
      .def_readonly("path", &io::CameraInfo::path, "Its device, '/dev/video0'.")
      .def_readonly("name", &io::CameraInfo::name, "As it calls itself.")
      .def_readonly("sizes_px", &io::CameraInfo::sizes_px, "Width, height; smallest first.")
      .def_readonly("fault", &io::CameraInfo::fault, "Why it cannot be opened; empty: it can.");
  m.def("list_cameras", &io::list_cameras,
        "The cameras of this machine in the order of their numbers.");
}

// `with` makes the file whole, or leaves none.
class PoseWriter {
 public:
  explicit PoseWriter(const path& file) : writer_(std::in_place, file.string(), false) {}
  void write(std::int64_t frame, const TrackResult& result) { writer().write(frame, result); }
  void exit(const py::object& fault, const py::object&, const py::object&) {
    if (fault.is_none()) writer().finish();
    writer_.reset();
  }

 private:
  io::PoseCsvWriter& writer() {
    if (!writer_) throw py::value_error("PoseWriter: the file is finished");
    return *writer_;
  }
  std::optional<io::PoseCsvWriter> writer_;
};

void bind_files(py::module_& m) {
  m.def(
      "read_camera", [](const path& file) { return io::read_camera(file.string()); }, "path"_a,
      "Reads a camera file of OpenCV or ROS (YAML). Raises Error naming file and field.");
  m.def(
      "write_camera",
      [](const path& file, const Camera& camera) { io::write_camera(file.string(), camera); },
      "path"_a, "camera"_a, "Writes a camera file (YAML), whole or not at all. Raises Error.");
  m.def(
      "read_hand", [](const path& file) { return io::read_hand(file.string()); }, "path"_a,
      "Reads a hand file (JSON). Raises Error naming file and field.");
  m.def(
      "write_hand",
      [](const path& file, const HandModel& hand) { io::write_hand(file.string(), hand); },
      "path"_a, "hand"_a, "Writes a hand file (JSON), whole or not at all. Raises Error.");
  m.def("data_file", &io::data_file, "name"_a,
        "Path of something shipped, e.g. 'sample/camera.yml'. Raises Error.");

  py::class_<PoseWriter>(m, "PoseWriter", R"(Writes a pose file (CSV), a row a frame:

    with handyar.io.PoseWriter("poses.csv") as poses:
        poses.write(frame.index, result)

The file takes its name at the end of the block; after an exception there is none.)")
      .def(py::init<const path&>(), "path"_a, "Begins a pose file. Raises Error.")
      .def("__enter__", [](py::object self) { return self; })
      .def("__exit__", &PoseWriter::exit, "type"_a, "value"_a, "traceback"_a)
      .def("write", &PoseWriter::write, "frame"_a, "result"_a,
           "Appends the row of frame number `frame`. Raises Error.");
}

}  // namespace
}  // namespace handyar::python

PYBIND11_MODULE(_io, m) {
  using namespace handyar::python;
  py::module_::import("handyar._core");  // whose classes are taken and given here
  m.attr("__name__") = "handyar.io";
  static py::exception<handyar::io::Error> error(m, "Error", PyExc_RuntimeError);
  error.attr("__doc__") =
      "What everything here raises: one line that names the file or device and what is wrong.";
  py::register_exception_translator([](std::exception_ptr fault) {
    try {
      if (fault) std::rethrow_exception(fault);
    } catch (const handyar::io::Error& e) {
      PyErr_SetObject(error.ptr(), text_of(e.what()).ptr());
    }
  });
  bind_frames(m);
  bind_files(m);
  m.attr("__name__") = "handyar._io";
}
