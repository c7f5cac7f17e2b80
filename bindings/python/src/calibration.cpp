// SPDX-License-Identifier: MIT
// handyar.calibration: camera and hand measured.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <optional>
#include <vector>

#include "arrays.hpp"
#include "frame.hpp"
#include "handyar/calibration/board_sheet.hpp"
#include "handyar/calibration/hand_calibration.hpp"
#include "handyar/calibration/self_calibration.hpp"
#include "handyar/calibration/session.hpp"
#include "shared.hpp"

namespace handyar::python {
namespace {

using namespace pybind11::literals;

void bind_results(py::module_& m) {
  py::class_<CameraCalibration>(m, "CameraCalibration", "A camera as measured.")
      .def_readonly("camera", &CameraCalibration::camera, "The camera.")
      .def_readonly("rms_px", &CameraCalibration::rms_px,
                    "Reprojection error over the views used, pixels.")
      .def_readonly("focal_sigma_px", &CameraCalibration::focal_sigma_px,
                    "Standard deviation of the focal length, pixels.")
      .def_readonly("centre_sigma_px", &CameraCalibration::centre_sigma_px,
                    "Standard deviation of the principal point (the worse axis), pixels.")
      .def_readonly("distortion", &CameraCalibration::distortion,
                    "The terms that the footage supports: 'none', 'k1', ...")
      .def_readonly("views_used", &CameraCalibration::views_used, "Frames used, counted from 0.");

  py::class_<HandCalibration>(m, "HandCalibration", "A hand as measured beside the board.")
      .def_readonly("hand", &HandCalibration::by_triangulation,
                    "The hand, its fingertips triangulated, with standard deviations.")
      .def_readonly("by_plane", &HandCalibration::by_plane,
                    "The paper's way: fingertips at `thickness_m` above the board.")
      .def_readonly("height_m", &HandCalibration::height_m,
                    "Mean height of the fingertips above the board as triangulated, metres.")
      .def_readonly("rms_difference_m", &HandCalibration::rms_difference_m,
                    "Between the two, in the plane of the board, metres.")
      .def_readonly("views_used", &HandCalibration::views_used, "Frames used, counted from 0.");

  py::class_<SelfCalibration>(m, "SelfCalibration", "A hand as measured by its own motion.")
      .def_readonly("hand", &SelfCalibration::hand,
                    "The hand: its shape from the views, its size from the known length or the "
                    "average adult.")
      .def_readonly("turned_rad", &SelfCalibration::turned_rad,
                    "Largest angle between the directions it was seen from, radians.")
      .def_readonly("views", &SelfCalibration::views, "In how many frames the hand was tracked.");
}

using Session = Shared<CalibrationSession>;

// A picture as the calibration room takes it: BGR, which a numpy picture may be as it lies.
bool add(Session& session, const py::object& bgr, const TrackResult& result,
         const HandModel& hand) {
  const ImageView view = view_of(bgr, "bgr");
  if (view.format != PixelFormat::bgr || view.stride_bytes < 0)
    throw py::value_error("bgr: its rows or channels lie reversed; numpy.ascontiguousarray helps");
  const cv::Mat picture(view.height_px, view.width_px, CV_8UC3,
                        const_cast<std::uint8_t*>(view.data),
                        static_cast<std::size_t>(view.stride_bytes));
  return session.use(
      [&](CalibrationSession& s) { return s.add(picture, result, hand).board_seen(); });
}

void bind_session(py::module_& m) {
  py::class_<Board>(m, "Board", "A checkerboard, by its inner corners: 9x7 squares have 8x6.")
      .def(py::init([](int columns, int rows, double square_m) {
             if (columns < 3 || rows < 3 || columns > 50 || rows > 50)
               throw py::value_error("columns, rows: 3 to 50 inner corners are wanted");
             if (!(square_m > 0)) throw py::value_error("square_m: metres are wanted, above 0");
             return Board{columns, rows, square_m};
           }),
           "columns"_a, "rows"_a, "square_m"_a,
           "Inner corners in a row, rows of them, side of a square in metres.")
      .def_readonly("columns", &Board::columns, "Inner corners in a row.")
      .def_readonly("rows", &Board::rows, "Rows of inner corners.")
      .def_readonly("square_m", &Board::square_m, "Side of a square, metres.")
      .def(
          "pdf", [](const Board& board) { return py::bytes(board_pdf(board)); },
          "The board to print in true size, the bytes of a PDF file.");

  py::class_<Session>(m, "Session", R"(Camera and hand from a checkerboard beside the hand.

The hand lies flat beside the board, back up, fingers spread, and stays still; the camera moves
slowly around both:

    session = handyar.calibration.Session(Board(8, 6, 0.025), source.width_px, source.height_px)
    for frame in source:
        result = tracker.process(frame.bgr, frame.time_s)
        session.add(frame.bgr, result, tracker.hand)
    camera = session.camera().camera
    hand = session.hand(camera).hand)")
      .def(py::init([](const Board& board, int width_px, int height_px) {
             if (width_px < 1 || height_px < 1)
               throw py::value_error("width_px, height_px: the size of a picture is wanted");
             return std::make_unique<Session>(CalibrationSession(board, {width_px, height_px}));
           }),
           "board"_a, "width_px"_a, "height_px"_a, "A board, and the size of the pictures.")
      .def("add", &add, "bgr"_a, "result"_a, "hand"_a,
           "Takes a frame, uint8, shape (height, width, 3), BGR, with what the tracker saw in it "
           "and "
           "the hand as it has learned it. Returns whether the board is seen. Raises "
           "CalibrationError where its size is not the session's.")
      .def_property_readonly(
          "done",
          [](Session& session) {
            return session.use([](const CalibrationSession& s) { return s.coverage().done(); });
          },
          "Whether there are views enough: further frames add little.")
      .def_property_readonly(
          "views",
          [](Session& session) {
            return session.use([](const CalibrationSession& s) { return s.coverage().views(); });
          },
          "How many different views of the board there are.")
      .def_property_readonly(
          "advice",
          [](Session& session) {
            return session.use([](const CalibrationSession& s) {
              return s.views().empty() ? std::string() : advice(s.coverage(), s.views().back());
            });
          },
          "The one thing to do next, for the person with the camera.")
      .def(
          "camera",
          [](Session& session) {
            return session.use([](const CalibrationSession& s) { return s.camera(); });
          },
          "The camera. Raises CalibrationError when the frames cannot carry it.")
      .def(
          "hand",
          [](Session& session, const Camera& camera, double thickness_m) {
            return session.use([&](const CalibrationSession& s) {
              return calibrate_hand(s.views(), camera, s.board(), thickness_m);
            });
          },
          "camera"_a, "thickness_m"_a = 0.005,
          "The hand, by this camera. thickness_m: height of a fingertip above the board, metres, "
          "for "
          "`by_plane`. Raises CalibrationError.");
}

// The views of a hand that turns before the camera.
using HandViews = std::vector<CalibrationView>;
using SelfSession = Shared<HandViews>;

void bind_self(py::module_& m) {
  py::class_<SelfSession>(m, "SelfSession", R"(A hand from its own motion, without a board.

The stiff, open hand turns before a calibrated camera:

    session = handyar.calibration.SelfSession()
    for frame in source:
        result = tracker.process(frame.bgr, frame.time_s)
        session.add(result, tracker.hand)
    hand = session.hand(camera, span_m=0.19).hand)")
      .def(py::init([] { return std::make_unique<SelfSession>(HandViews()); }))
      .def(
          "add",
          [](SelfSession& session, const TrackResult& result, const HandModel& hand) {
            session.use([&](HandViews& views) { views.push_back(hand_view(result, hand)); });
          },
          "result"_a, "hand"_a,
          "Takes what the tracker saw in a frame and the hand as it has learned it.")
      .def(
          "hand",
          [](SelfSession& session, const Camera& camera, std::optional<double> span_m,
             std::optional<double> hand_length_m) {
            if (span_m && hand_length_m)
              throw py::value_error("span_m, hand_length_m: one of them is enough");
            return session.use([&](const HandViews& views) {
              return self_calibrate_hand(views, camera, {span_m, hand_length_m});
            });
          },
          "camera"_a, py::kw_only(), "span_m"_a = py::none(), "hand_length_m"_a = py::none(),
          R"(The hand, its size from a length measured with a ruler, in metres, or an average adult's.

span_m: thumb tip to little fingertip, as spread in the frames. hand_length_m: crease of the wrist
to the tip of the middle finger. Raises CalibrationError when it cannot be trusted.)");
}

}  // namespace
}  // namespace handyar::python

PYBIND11_MODULE(calibration, m) {
  using namespace handyar::python;
  py::module_::import("handyar._core");
  m.doc() = "Camera and hand measured, with a checkerboard or without.";
  py::register_exception<handyar::CalibrationError>(m, "CalibrationError", PyExc_RuntimeError)
      .attr("__doc__") =
      "A calibration that cannot be trusted: what is wrong with the recording and what to do.";
  bind_results(m);
  bind_session(m);
  bind_self(m);
}
