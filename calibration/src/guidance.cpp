// SPDX-License-Identifier: MIT
#include "handyar/calibration/guidance.hpp"

#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "handyar/calibration/camera_calibration.hpp"
#include "text.hpp"

namespace handyar {
namespace {

constexpr double kTilted_rad = 15 * std::numbers::pi / 180;
constexpr double kDifferent = 0.25;  // of viewpoints, see difference()
constexpr int kEnoughFromOneSide = 2;

const cv::Scalar kGreen(90, 200, 90), kGrey(70, 70, 70), kWhite(240, 240, 240), kBlack(25, 25, 25);
const cv::Scalar kOrange(60, 160, 255);

// The camera stands where the board's normal does not point: a board whose normal leans to the
// right of the ray is seen from its left.
BoardSide side_of(const Viewpoint& v, const Camera& camera) {
  const Eigen::Vector3d ray =
      camera.unproject({v.centre.x() * camera.width_px, v.centre.y() * camera.height_px})
          .homogeneous()
          .normalized();
  if (std::acos(std::clamp(-ray.dot(v.normal), -1.0, 1.0)) < kTilted_rad) return BoardSide::above;
  const Eigen::Vector3d lean = v.normal + ray;
  if (std::abs(lean.x()) > std::abs(lean.y()))
    return lean.x() > 0 ? BoardSide::left : BoardSide::right;
  return lean.y() > 0 ? BoardSide::far : BoardSide::near;
}

void write(cv::Mat& image, const std::string& line, cv::Point at, const cv::Scalar& colour,
           double size = 0.45) {
  cv::putText(image, line, at, cv::FONT_HERSHEY_SIMPLEX, size, colour, 1, cv::LINE_AA);
}

void draw_cells(cv::Mat& panel, const Coverage& coverage, cv::Rect area) {
  const int w = area.width / Coverage::kColumns, h = area.height / Coverage::kRows;
  for (int j = 0; j < Coverage::kRows; ++j)
    for (int i = 0; i < Coverage::kColumns; ++i)
      cv::rectangle(panel, cv::Rect(area.x + i * w, area.y + j * h, w - 2, h - 2),
                    coverage.cell(i, j) ? kGreen : kGrey, cv::FILLED);
}

void draw_sides(cv::Mat& panel, const Coverage& coverage, cv::Point centre, int radius) {
  const std::array<cv::Point, kSideCount> at = {
      centre, centre - cv::Point(radius, 0), centre + cv::Point(radius, 0),
      centre + cv::Point(0, radius), centre - cv::Point(0, radius)};
  for (int s = 0; s < kSideCount; ++s) {
    const bool enough = coverage.views_from(static_cast<BoardSide>(s)) >= kEnoughFromOneSide;
    cv::circle(panel, at[s], radius / 3, enough ? kGreen : kGrey, cv::FILLED, cv::LINE_AA);
  }
}

std::string place_name(int column, int row) {
  const char* vertical = row < Coverage::kRows / 3        ? "top"
                         : row >= 2 * Coverage::kRows / 3 ? "bottom"
                                                          : "middle";
  const char* horizontal = column < Coverage::kColumns / 2 ? "left" : "right";
  return text("%s %s", vertical, horizontal);
}

// The sixth of the picture with the most empty cells.
std::string emptiest_place(const Coverage& coverage) {
  constexpr int kHeight = Coverage::kRows / 3, kWidth = Coverage::kColumns / 2;
  int most = -1;
  std::string name;
  for (int row = 0; row < Coverage::kRows; row += kHeight)
    for (int column = 0; column < Coverage::kColumns; column += kWidth) {
      int empty = 0;
      for (int j = row; j < row + kHeight; ++j)
        for (int i = column; i < column + kWidth; ++i) empty += !coverage.cell(i, j);
      if (empty > most) most = empty, name = place_name(column, row);
    }
  return name;
}

}  // namespace

Coverage::Coverage(const Board& board, cv::Size image_size, bool hand_wanted)
    : board_(board),
      rough_(Camera::from_field_of_view(image_size.width, image_size.height)),
      max_blur_px_(kMaxBlurPx * std::max(image_size.width, image_size.height) / 640.0),
      hand_wanted_(hand_wanted) {}

void Coverage::add(const CalibrationView& view) {
  if (!view.board_seen() || view.blur_px > max_blur_px_) return;
  const Viewpoint v = viewpoint(board_pose(view.corners_px, board_, rough_), board_.centre_m(),
                                -Eigen::Vector3d::UnitZ(), rough_);
  for (const Viewpoint& old : viewpoints_)
    if (difference(v, old) < kDifferent) return;
  viewpoints_.push_back(v);
  hand_views_ += view.hand_seen();
  ++sides_[static_cast<int>(side_of(v, rough_))];
  for (const cv::Point2f& c : view.corners_px) {
    const int column = static_cast<int>(c.x * kColumns / static_cast<float>(rough_.width_px));
    const int row = static_cast<int>(c.y * kRows / static_cast<float>(rough_.height_px));
    cells_[std::clamp(row, 0, kRows - 1) * kColumns + std::clamp(column, 0, kColumns - 1)] = true;
  }
}

double Coverage::cells_share() const {
  return static_cast<double>(std::count(cells_.begin(), cells_.end(), true)) / (kColumns * kRows);
}

int Coverage::sides_seen() const {
  return static_cast<int>(
      std::count_if(sides_.begin(), sides_.end(), [](int n) { return n >= kEnoughFromOneSide; }));
}

bool Coverage::done() const {
  return views() >= kViewsWanted && !needs_hand() && sides_seen() >= kSidesWanted &&
         cells_share() >= kCellsWanted;
}

std::string advice(const Coverage& coverage, const CalibrationView& now) {
  if (coverage.done()) return "Done.";
  if (!now.board_seen()) return "Show the whole board.";
  if (!now.hand_seen() && coverage.needs_hand())
    return "Lay the hand beside the board, fingers spread, and show both.";
  if (coverage.sides_seen() < Coverage::kSidesWanted)
    for (int s = 0; s < kSideCount; ++s)
      if (coverage.views_from(static_cast<BoardSide>(s)) < kEnoughFromOneSide)
        return text("Look from %s.", std::string(kSideNames[s]).c_str());
  if (coverage.cells_share() < Coverage::kCellsWanted)
    return text("Bring the board to the %s of the picture.", emptiest_place(coverage).c_str());
  return "Move on slowly, nearer and farther.";
}

cv::Mat draw_guidance(const cv::Mat& bgr, const Coverage& coverage, const CalibrationView& now) {
  constexpr int kPanel = 200, kLine = 40;
  cv::Mat out(std::max(bgr.rows, 360) + kLine, bgr.cols + kPanel, CV_8UC3, kBlack);
  cv::Mat frame = out(cv::Rect(0, 0, bgr.cols, bgr.rows));
  bgr.copyTo(frame);
  for (const cv::Point2f& c : now.corners_px) cv::circle(frame, c, 3, kGreen, 1, cv::LINE_AA);
  for (const Tip& t : now.tips)
    if (t.seen) cv::circle(frame, cv::Point2d(t.px.x(), t.px.y()), 5, kOrange, 2, cv::LINE_AA);

  cv::Mat panel = out(cv::Rect(bgr.cols, 0, kPanel, out.rows));
  const int left = 16;
  write(panel, "board", {left, 28}, now.board_seen() ? kGreen : kGrey);
  write(panel, "hand", {left + 80, 28}, now.hand_seen() ? kGreen : kGrey);
  write(panel, text("%d of %d views", coverage.views(), Coverage::kViewsWanted), {left, 56},
        kWhite);
  write(panel, "places", {left, 90}, kWhite);
  draw_cells(panel, coverage, {left, 100, kPanel - 2 * left, 96});
  write(panel, "directions", {left, 224}, kWhite);
  draw_sides(panel, coverage, {kPanel / 2, 290}, 44);
  write(out, advice(coverage, now), {left, out.rows - 14}, coverage.done() ? kGreen : kWhite, 0.6);
  return out;
}

}  // namespace handyar
