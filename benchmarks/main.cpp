// SPDX-License-Identifier: MIT
//
// Runs the benchmarks, then prints the paper's Table 1: what each stage takes in milliseconds, at
// full and half resolution, next to marker detection and a copy of the same frames.
#include <cstdio>
#include <exception>
#include <map>
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

  void print_table() const {
    static constexpr const char* kColumns[] = {"tracker/full/searching", "tracker/full/tracking",
                                               "tracker/half/searching", "tracker/half/tracking"};
    for (const char* column : kColumns)
      if (!values_.contains(column)) return;  // some were filtered out
    std::printf("\nMedian milliseconds of a %dx%d frame, one thread\n\n", clip().frames[0].cols,
                clip().frames[0].rows);
    std::printf(
        "| stage (paper, Table 1) | full, searching | full, tracking | half, searching | "
        "half, tracking |\n| --- | ---: | ---: | ---: | ---: |\n");
    for (const char* stage :
         {"segmentation", "fingertips", "matching", "pose", "filter", "total"}) {
      std::printf("| %s |", stage);
      for (const char* column : kColumns) std::printf(" %.3f |", value(column, stage));
      std::printf("\n");
    }
    std::printf("| ArUco detection | %.3f | | | |\n", value("aruco", "total"));
    std::printf("| copy of the frame | %.3f | | | |\n", value("copy", "total"));
  }

 private:
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
  reporter.print_table();
} catch (const std::exception& e) {
  std::fprintf(stderr, "handyar_benchmark: %s\n", e.what());
  return 1;
}
