// SPDX-License-Identifier: MIT
//
// Runs the benchmarks, then prints two tables: the paper's Table 1, what each stage takes in
// milliseconds by either method; and the whole tracker at three sizes of frame, next to marker
// detection and a copy of the same frames.
#include <cstdio>
#include <exception>
#include <map>
#include <opencv2/imgproc.hpp>
#include <string>

#include "clip.hpp"
#include "handyar/io/camera_file.hpp"
#include "handyar/io/frame_source.hpp"
#include "handyar/io/hand_file.hpp"
#include "handyar/io/sample.hpp"

namespace handyar::benchmarks {

const Clip& clip() {
  static const Clip clip = [] {
    Clip c;
    const auto source = io::open_input(io::data_file("compare/video.mp4"));
    for (io::Frame frame; source->read(frame);) c.frames.push_back(frame.bgr.clone());
    c.camera = io::read_camera(io::data_file("compare/camera.yml"));
    c.hand = io::read_hand(io::data_file("compare/hand.json"));
    return c;
  }();
  return clip;
}

const Clip& clip_at(int width, int height) {
  static Clip scaled;
  if (!scaled.frames.empty() && scaled.frames[0].size() == cv::Size(width, height)) return scaled;
  constexpr std::size_t kFrames = 40;
  const std::vector<cv::Mat>& all = clip().frames;
  scaled = {{}, clip().camera, clip().hand};
  const double scale = static_cast<double>(height) / all[0].rows;
  const int inner = static_cast<int>(all[0].cols * scale), side = (width - inner) / 2;
  for (std::size_t i = all.size() - std::min(all.size(), kFrames); i < all.size(); ++i) {
    cv::Mat large, wide;
    cv::resize(all[i], large, {inner, height}, 0, 0, cv::INTER_CUBIC);
    cv::copyMakeBorder(large, wide, 0, 0, side, width - inner - side, cv::BORDER_REPLICATE);
    scaled.frames.push_back(wide);
  }
  scaled.camera = clip().camera.scaled_to(inner, height);
  scaled.camera.width_px = width;
  scaled.camera.cx_px += side;
  return scaled;
}

namespace {

/// Prints as usual and keeps the counters for the table.
class Reporter : public benchmark::ConsoleReporter {
 public:
  void ReportRuns(const std::vector<Run>& runs) override {
    ConsoleReporter::ReportRuns(runs);
    for (const Run& run : runs)
      for (const auto& [counter, value] : run.counters)
        values_[run.run_name.function_name][counter] = value.value;
  }

  void print_tables() const {
    print_stages();
    print_sizes();
  }

 private:
  void print_stages() const {
    static constexpr const char* kColumns[] = {"640x480/tracking", "paper/full", "paper/half"};
    for (const char* column : kColumns)
      if (!values_.contains(column)) return;  // some were filtered out
    std::printf("\nMedian milliseconds of a 640x480 frame while tracking, one thread\n\n");
    std::printf(
        "| stage (paper, Table 1) | figure | paper, full | paper, half |\n"
        "| --- | ---: | ---: | ---: |\n");
    for (const char* stage :
         {"segmentation", "fingertips", "matching", "pose", "filter", "total"}) {
      std::printf("| %s |", stage);
      for (const char* column : kColumns) std::printf(" %.3f |", value(column, stage));
      std::printf("\n");
    }
  }

  /// Ratios of the same run hardly depend on the machine and on what else it does.
  void print_sizes() const {
    std::printf(
        "\n| frame | tracking (ms) | 99 %% | finding (ms) | 99 %% | no hand (ms) | 99 %% | "
        "ArUco (ms) | copy (ms) | ArUco / tracking |\n"
        "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n");
    for (const std::string size : {"640x480", "1280x720", "1920x1080"}) {
      const double tracking = value(size + "/tracking", "total");
      const double aruco = value(size + "/aruco", "total");
      if (tracking * aruco == 0) continue;  // some were filtered out
      std::printf("| %s | %.3f | %.3f | %.3f | %.3f | %.3f | %.3f | %.2f | %.3f | %.1f |\n",
                  size.c_str(), tracking, value(size + "/tracking", "p99"),
                  value(size + "/finding", "total"), value(size + "/finding", "p99"),
                  value(size + "/searching", "total"), value(size + "/searching", "p99"), aruco,
                  value(size + "/copy", "total"), aruco / tracking);
    }
  }

  double value(const std::string& run, const std::string& counter) const {
    const auto found = values_.find(run);
    if (found == values_.end() || !found->second.contains(counter)) return 0;
    return found->second.at(counter);
  }

  std::map<std::string, std::map<std::string, double>> values_;
};

}  // namespace
}  // namespace handyar::benchmarks

int main(int argc, char** argv) try {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  handyar::benchmarks::register_tracker_benchmarks();
  handyar::benchmarks::register_stage_benchmarks();
  handyar::benchmarks::Reporter reporter;
  benchmark::RunSpecifiedBenchmarks(&reporter);
  reporter.print_tables();
} catch (const std::exception& e) {
  std::fprintf(stderr, "handyar_benchmark: %s\n", e.what());
  return 1;
}
