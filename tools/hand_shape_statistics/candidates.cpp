// SPDX-License-Identifier: MIT
// The hand-like shapes that the hand search finds in annotated frames: see README.md.
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>
#include <string>

#include "handyar/hand_search.hpp"
#include "handyar/io/error.hpp"
#include "handyar/io/frame_source.hpp"

namespace {

using namespace handyar;

constexpr int kReadings = 64;  // at least as many as the search has
constexpr int kMaxSide_px = 2000;

struct Annotation {
  double weight = 0;
  std::string file;
  int frame = -1;
  std::array<Eigen::Vector2d, kFingerCount> tips_px;
};

std::istream& operator>>(std::istream& in, Annotation& a) {
  in >> a.weight >> a.file >> a.frame;
  for (Eigen::Vector2d& tip : a.tips_px) in >> tip.x() >> tip.y();
  return in;
}

/// The annotated picture; stills are reduced to fit into 640x480, with their annotation.
class Pictures {
 public:
  cv::Mat read(Annotation& a) {
    if (a.frame < 0) return still(a);
    if (a.file != file_ || a.frame <= frame_.index) {
      source_ = io::open_input(a.file);
      file_ = a.file;
      frame_.index = -1;
    }
    while (frame_.index < a.frame)
      if (!source_->read(frame_))
        throw io::Error(a.file, "has no frame " + std::to_string(a.frame));
    return frame_.bgr;
  }

 private:
  static cv::Mat still(Annotation& a) {
    cv::Mat picture = cv::imread(a.file, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
    if (picture.empty()) throw io::Error(a.file, "cannot be read");
    const double scale = std::min(640.0 / picture.cols, 480.0 / picture.rows);
    cv::resize(picture, picture,
               {int(picture.cols * scale) / 2 * 2, int(picture.rows * scale) / 2 * 2}, 0, 0,
               cv::INTER_AREA);
    for (Eigen::Vector2d& tip : a.tips_px) tip *= scale;
    return picture;
  }

  std::string file_;
  std::unique_ptr<io::FrameSource> source_;
  io::Frame frame_;
};

/// One reading a call, and wide limits: what is right is told by the annotation.
HandSearchConfig one_reading() {
  HandSearchConfig config;
  config.readings_per_frame = 1;
  config.max_deviation = 3;
  return config;
}
HandShapeConfig wide_limits() {
  HandShapeConfig config;
  config.min_finger_fill = 0.4;
  config.min_palm_fill = 0.8;
  return config;
}

void print(const Annotation& a, const BinView& image, const HandShape& shape) {
  const double span_px = (a.tips_px[0] - a.tips_px[4]).norm();
  double worst = 0;
  for (int f = 0; f < kFingerCount; ++f) {
    const Eigen::Vector2d at(image.x_px(shape.tips[f].x()), image.y_px(shape.tips[f].y()));
    worst = std::max(worst, (at - a.tips_px[f]).norm() / span_px);
  }
  std::printf("%s %d %.4f %d", a.file.c_str(), a.frame, worst, int(shape.layout));
  for (const auto& p : shape.tips) std::printf(" %g %g", p.x(), p.y());
  for (const auto& p : shape.valleys) std::printf(" %g %g", p.x(), p.y());
  std::printf("\n");
}

void run(const char* list) {
  std::ifstream lines(list);
  if (!lines) throw io::Error(list, "cannot be read");
  MaskStages stages;
  HandSearch search(stages, one_reading(), wide_limits());
  stages.reserve(kMaxSide_px * kMaxSide_px / 4);
  search.reserve(kMaxSide_px * kMaxSide_px / 4);
  const SkinModel skin;
  Pictures pictures;
  BinImage image;
  image.bins.resize(kMaxSide_px * kMaxSide_px / 4);
  std::string line;
  while (std::getline(lines, line)) {
    Annotation a;
    if (!(std::istringstream(line) >> a)) throw io::Error(list, "not a frame: " + line);
    const cv::Mat picture = pictures.read(a);
    const ImageView view{picture.data, picture.cols, picture.rows, std::ptrdiff_t(picture.step[0]),
                         PixelFormat::bgr};
    const int step = std::max(2, (std::max(picture.cols, picture.rows) + 160) / 320);
    read_bins(view, {0, 0, picture.cols, picture.rows}, step, image);
    search.reset();
    HandShape before;
    for (int i = 0; i < kReadings; ++i) {
      HandShape shape;
      if (!search.find(image, skin, shape)) continue;
      if (i > 0 && shape.tips == before.tips) continue;  // the prior's, which is always tried too
      before = shape;
      print(a, search.image(), shape);
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: hand_shape_candidates FRAMES.txt > CANDIDATES.txt\n");
    return 2;
  }
  try {
    run(argv[1]);
  } catch (const io::Error& e) {
    std::fprintf(stderr, "hand_shape_candidates: %s\n", e.what());
    return 1;
  }
  return 0;
}
