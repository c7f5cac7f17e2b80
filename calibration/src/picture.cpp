// SPDX-License-Identifier: MIT
#include "handyar/calibration/picture.hpp"

#include <opencv2/imgproc.hpp>

#include "handyar/stages/hand_figure.hpp"
#include "text.hpp"

namespace handyar {
namespace {

constexpr double kPxPerM = 4000;
constexpr double kMargin_m = 0.025;
constexpr int kShift = 4;  // OpenCV draws with 1/16 pixel

const cv::Scalar kInk(40, 40, 40), kTipColour(200, 90, 20), kAxisX(60, 60, 220),
    kAxisY(60, 160, 60), kFigure(150, 175, 215), kPlane(170, 60, 170);

// Drawing in metres of a plane looked at from above: with a board its x to the right, y down.
class Plane {
 public:
  Plane(const std::vector<Eigen::Vector2d>& points, bool y_down) : y_down_(y_down) {
    Eigen::Vector2d low = points.front(), high = points.front();
    for (const auto& p : points) low = low.cwiseMin(p), high = high.cwiseMax(p);
    low_ = low.array() - kMargin_m;
    high_ = high.array() + kMargin_m;
    const Eigen::Vector2d size = (high_ - low_) * kPxPerM;
    image_.create(cvRound(size.y()) + kCaption, cvRound(size.x()), CV_8UC3);
    image_.setTo(cv::Scalar(255, 255, 255));
  }

  cv::Point2d px(const Eigen::Vector2d& p) const {
    return {(p.x() - low_.x()) * kPxPerM,
            (y_down_ ? p.y() - low_.y() : high_.y() - p.y()) * kPxPerM};
  }
  cv::Point fine(const Eigen::Vector2d& p) const {
    return {cvRound(px(p).x * (1 << kShift)), cvRound(px(p).y * (1 << kShift))};
  }
  void polygon(const std::vector<Eigen::Vector2d>& points, const cv::Scalar& colour, bool filled) {
    std::vector<cv::Point> v;
    for (const auto& p : points) v.push_back(fine(p));
    const std::vector<std::vector<cv::Point>> all{v};
    if (filled)
      cv::fillPoly(image_, all, colour, cv::LINE_AA, kShift);
    else
      cv::polylines(image_, all, true, colour, 2, cv::LINE_AA, kShift);
  }
  void arrow(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const cv::Scalar& colour,
             const char* name) {
    cv::arrowedLine(image_, fine(from), fine(to), colour, 2, cv::LINE_AA, kShift, 0.12);
    write(name, px(to) + cv::Point2d(6, -6), colour);
  }
  void dot(const Eigen::Vector2d& p, int radius_px, const cv::Scalar& colour) {
    cv::circle(image_, fine(p), radius_px << kShift, colour, cv::FILLED, cv::LINE_AA, kShift);
  }
  void cross(const Eigen::Vector2d& p, const cv::Scalar& colour) {
    cv::drawMarker(image_, px(p), colour, cv::MARKER_TILTED_CROSS, 14, 2, cv::LINE_AA);
  }
  void write(const std::string& line, cv::Point2d at, const cv::Scalar& colour) {
    cv::putText(image_, line, at, cv::FONT_HERSHEY_SIMPLEX, 0.55, colour, 1, cv::LINE_AA);
  }
  void caption(const std::string& line, int row) {
    write(line, {16.0, image_.rows - kCaption + 24.0 * (row + 1)}, kInk);
  }
  cv::Mat image() const { return image_; }

 private:
  static constexpr int kCaption = 84;
  bool y_down_;
  Eigen::Vector2d low_, high_;
  cv::Mat image_;
};

// Points of the picture's plane: the board's when there is one, else the hand's.
struct Placed {
  Eigen::Isometry3d T;
  Eigen::Vector2d operator()(const Eigen::Vector3d& p_hand) const { return (T * p_hand).head<2>(); }
  Eigen::Vector2d operator()(double x, double y) const { return (*this)({x, y, 0}); }
};

std::vector<Eigen::Vector2d> square(double x, double y, double side) {
  return {{x, y}, {x + side, y}, {x + side, y + side}, {x, y + side}};
}

void draw_board(Plane& plane, const Board& board) {
  const double s = board.square_m;
  for (int j = -1; j < board.rows; ++j)
    for (int i = -1; i < board.columns; ++i)
      if ((i + j) % 2 == 0) plane.polygon(square(i * s, j * s, s), cv::Scalar(120, 120, 120), true);
}

// The hulls of the figure, seen from above.
void draw_figure(Plane& plane, const HandModel& hand, const Placed& placed) {
  const HandFigure figure = make_figure(hand, Face::palm, hand.layout);
  constexpr int kSteps = 24;
  for (const auto& hull : figure_hulls()) {
    std::vector<cv::Point2f> rims;
    for (const int sphere : hull) {
      if (sphere < 0) continue;
      const Eigen::Vector3d centre = figure.centres_m.col(sphere);
      for (int i = 0; i < kSteps; ++i) {
        const double a = 2 * CV_PI * i / kSteps, r = figure.radii_m[sphere];
        const Eigen::Vector2d p = placed(centre.x() + r * std::cos(a), centre.y() + r * std::sin(a));
        rims.emplace_back(p.x(), p.y());
      }
    }
    std::vector<cv::Point2f> around;
    cv::convexHull(rims, around);
    std::vector<Eigen::Vector2d> polygon;
    for (const cv::Point2f& p : around) polygon.emplace_back(p.x, p.y);
    plane.polygon(polygon, kFigure, true);
  }
}

void draw_tips(Plane& plane, const HandModel& hand, const Placed& placed) {
  constexpr int kSteps = 48;
  for (int k = 0; k < kFingerCount; ++k) {
    const Eigen::Vector3d tip = hand.tips_m.col(k), sigma = hand.tips_sigma_m.col(k);
    plane.dot(placed(tip), 2, kTipColour);
    plane.write(std::string(kFingerNames[k]), plane.px(placed(tip)) + cv::Point2d(12, -10), kInk);
    if (sigma.isZero()) continue;
    std::vector<Eigen::Vector2d> ellipse;
    for (int i = 0; i < kSteps; ++i) {
      const double a = 2 * CV_PI * i / kSteps;
      ellipse.push_back(
          placed(tip + 2 * Eigen::Vector3d(sigma.x() * std::cos(a), sigma.y() * std::sin(a), 0)));
    }
    plane.polygon(ellipse, kTipColour, false);
  }
}

void draw_axes(Plane& plane, const Placed& placed) {
  constexpr double kAxis_m = 0.05;
  plane.arrow(placed(0, 0), placed(kAxis_m, 0), kAxisX, "x");
  plane.arrow(placed(0, 0), placed(0, kAxis_m), kAxisY, "y");
}

void write_caption(Plane& plane, const HandPicture& picture) {
  const Eigen::Matrix3Xd& sigma = picture.hand.tips_sigma_m;
  plane.caption(text("span %.1f mm, %s, %.2f px rms", 1000 * picture.hand.span_m(),
                     std::string(name(picture.hand.layout)).c_str(), picture.hand.rms_px),
                0);
  if (!sigma.isZero())
    plane.caption(text("ellipses: two standard deviations, largest %.1f mm",
                       2000 * sigma.topRows<2>().maxCoeff()),
                  1);
  if (picture.plane_tips_board_m)
    plane.caption(text("crosses: at %.4g mm above the board, the paper's way",
                       -1000 * picture.plane_tips_board_m->row(2).mean()),
                  2);
}

}  // namespace

cv::Mat draw_hand(const HandPicture& picture) {
  const HandModel& hand = picture.hand;
  const Placed placed{picture.board ? picture.T_board_hand : Eigen::Isometry3d::Identity()};
  std::vector<Eigen::Vector2d> all;
  for (int k = 0; k < kFingerCount; ++k) all.push_back(placed(hand.tips_m.col(k)));
  all.push_back(placed(0, 0));
  if (picture.board) {
    const Board& b = *picture.board;
    all.emplace_back(-b.square_m, -b.square_m);
    all.emplace_back(b.columns * b.square_m, b.rows * b.square_m);
  }
  Plane plane(all, picture.board.has_value());
  if (picture.board) draw_board(plane, *picture.board);
  if (hand.figure) draw_figure(plane, hand, placed);
  draw_axes(plane, placed);
  draw_tips(plane, hand, placed);
  if (picture.plane_tips_board_m)
    for (int k = 0; k < kFingerCount; ++k)
      plane.cross(picture.plane_tips_board_m->col(k).head<2>(), kPlane);
  write_caption(plane, picture);
  return plane.image();
}

}  // namespace handyar
