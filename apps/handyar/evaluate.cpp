// SPDX-License-Identifier: MIT
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>

#include "command.hpp"
#include "handyar/api.h"
#include "handyar/evaluation/footage.hpp"
#include "handyar/evaluation/report.hpp"
#include "output_folder.hpp"

namespace handyar::cli {
namespace {

using namespace handyar::evaluation;
namespace fs = std::filesystem;

constexpr const char* kEvaluateExamples =
    "A SEQUENCE is a video file, or a folder with video.mp4 and, where there are such, "
    "truth.json,\n"
    "camera.yml and hand.json. A FOLDER without video.mp4 is a tree of such folders and of clips "
    "named in\n"
    "an open_frames.csv: of it only the default method is measured, and how its figures are "
    "distributed\n"
    "over sequences.\n\n"
    "Examples:\n"
    "  handyar evaluate sample --report report\n"
    "  handyar evaluate hand.mp4 --camera camera.yml --hand hand.json --board 8x6 --square-mm 25 "
    "\\\n"
    "                   --report report\n"
    "  handyar evaluate footage --uncalibrated --report report\n"
    "  handyar evaluate --stills stills/fingertips.csv --report report";

/// As a shell reads it back.
std::string shell_quoted(const std::string& argument) {
  constexpr const char* kSafe =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-+=.,:/@%";
  if (!argument.empty() && argument.find_first_not_of(kSafe) == std::string::npos) return argument;
  std::string text = "'";
  for (const char c : argument) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

/// The command line that this process was started with; empty where the system does not tell.
std::string command_line() {
  std::ifstream file("/proc/self/cmdline", std::ios::binary);
  std::string text;
  for (std::string argument; std::getline(file, argument, '\0');)
    text += (text.empty() ? "" : " ") + shell_quoted(argument);
  return text;
}

struct Evaluation {
  std::vector<std::string> sequences;
  SequenceOptions options;
  std::string stills, report;
  int begins = 1;
  std::string board;
  double square_mm = 0, aruco_mm = 0, apriltag_mm = 0;
  std::string aruco_dictionary = "DICT_4X4_50";
};

/// Options that what is evaluated makes no use of.
void refuse_without_effect(const Evaluation& e, bool trees) {
  const bool prints = !e.board.empty() || e.aruco_mm > 0 || e.apriltag_mm > 0;
  if (trees && prints) throw WrongUsage("of a tree neither board nor markers are evaluated");
  if (!trees && e.begins > 1) throw WrongUsage("--begins is for trees");
  const bool known = !e.options.camera_file.empty() || !e.options.hand_file.empty();
  if (e.sequences.empty() && (prints || known || e.options.uncalibrated))
    throw WrongUsage("photographs alone have no camera, hand, board or marker that is known");
}

/// What the options say of the person and of the prints in view.
SequenceOptions sequence_options(const Evaluation& e) {
  SequenceOptions o = e.options;
  if (!e.board.empty()) {
    const auto grid = parse_grid(e.board);
    if (!grid) throw WrongUsage("--board " + e.board + " is not like 8x6, from 3x3 to 50x50");
    o.board = Board{grid->width, grid->height, e.square_mm * 1e-3};
  }
  if (e.aruco_mm > 0) o.aruco = Marker{e.aruco_dictionary, -1, e.aruco_mm * 1e-3};
  if (e.apriltag_mm > 0) o.apriltag = Marker{kAprilTagDictionary, -1, e.apriltag_mm * 1e-3};
  return o;
}

bool is_tree(const std::string& path) {
  return fs::is_directory(path) && !fs::exists(fs::path(path) / "video.mp4");
}

/// Why videos ended early, empty where one did not; gives the exit code. What could be read of a
/// broken video is in the report, it is a failure all the same.
int tell(const std::vector<std::string>& faults) {
  int code = kDone;
  for (const std::string& fault : faults) {
    if (fault.empty()) continue;
    std::cerr << "handyar: " << fault << '\n';
    code = kFailed;
  }
  return code;
}

/// How the default method's figures are distributed over all sequences of the trees.
int evaluate_trees(const Evaluation& e) {
  std::vector<Footage> footage;
  for (const std::string& tree : e.sequences)
    for (Footage& f : find_footage(tree, sequence_options(e))) footage.push_back(std::move(f));
  catch_interrupts();
  const OutputFolder folder(e.report, {"sequences.csv", "distribution.md"});
  std::vector<FootageFigures> figures;
  {
    ProgressLine line("sequences: ");
    for (const Footage& f : footage) {
      require_no_interrupt();
      figures.push_back(measure(f, e.begins));
      line.show(int(figures.size()), int(footage.size()));
    }
  }
  std::cout << write_distribution(e.report, figures) << folder.file("distribution.md") << '\n';
  std::vector<std::string> faults;
  for (const FootageFigures& f : figures) faults.push_back(f.broken_off);
  return tell(faults);
}

int evaluate(const Evaluation& e) {
  if (e.sequences.empty() && e.stills.empty())
    throw WrongUsage("nothing to evaluate: give a SEQUENCE or --stills");
  if (e.report.empty()) throw WrongUsage("--report: the folder's name is empty");
  const auto trees = std::count_if(e.sequences.begin(), e.sequences.end(), is_tree);
  refuse_without_effect(e, trees > 0);
  if (trees > 0) {
    if (std::size_t(trees) < e.sequences.size() || !e.stills.empty())
      throw WrongUsage("a tree of sequences is evaluated alone");
    return evaluate_trees(e);
  }
  const fs::path report = e.report;
  require_distinct_files({e.stills, e.options.camera_file, e.options.hand_file},
                         {report / "report.html", report / "errors.csv", report / "stills.csv",
                          report / "tables.csv"});
  // What goes in is known to be good before anything is made, and all that before the long work.
  const SequenceOptions options = sequence_options(e);
  const std::vector<Sequence> sequences = open_sequences(e.sequences, options);
  const std::vector<Still> photographs =
      e.stills.empty() ? std::vector<Still>() : read_stills(e.stills);
  catch_interrupts();
  const OutputFolder folder(e.report,
                            {"report.html", "errors.csv", "stills.csv", "tables.csv", "tables.md"});

  std::vector<Analysis> analyses;
  for (const Sequence& s : sequences) {
    ProgressLine line(s.name + ": ");
    analyses.push_back(analyse(record(s, Methods::all, [&](int done, int of) {
      require_no_interrupt();
      line.show(done, of);
    })));
  }
  std::vector<StillResult> stills;
  if (!photographs.empty()) {
    ProgressLine line("stills: ");
    stills = track_stills(photographs, [&](int done, int of) {
      require_no_interrupt();
      line.show(done, of);
    });
  }
  const RunDescription run{command_line(), HANDYAR_VERSION};
  for (const std::string& note : write_report(e.report, run, analyses, stills))
    std::cerr << "handyar: " << note << '\n';
  std::cout << folder.file("report.html") << '\n';
  std::vector<std::string> faults;
  for (const Analysis& a : analyses) faults.push_back(a.recording.broken_off);
  return tell(faults);
}

}  // namespace

Command add_evaluate(CLI::App& app) {
  CLI::App* options = app.add_subcommand(
      "evaluate", "Measure speed and accuracy against markers and truth, as a report");
  const auto e = std::make_shared<Evaluation>();
  options->add_option("SEQUENCE", e->sequences, "Videos, folders with video.mp4, or trees of them");
  options
      ->add_option("--report", e->report,
                   "Folder for report.html, tables.csv and .md, errors.csv, stills.csv, poses/, "
                   "figure8-*.png")
      ->required();
  options->add_option("--camera", e->options.camera_file, "Camera file (YAML) for all of them");
  options->add_option("--hand", e->options.hand_file, "Hand file (JSON) for all of them");
  options
      ->add_flag("--uncalibrated", e->options.uncalibrated,
                 "The average hand, though a measured one is known")
      ->excludes("--hand");
  options
      ->add_option("--begins", e->begins,
                   "Of a tree: how often each clip of an open_frames.csv is begun, each time "
                   "from another place")
      ->check(between(1, 100));
  CLI::Option* const board =
      options->add_option("--board", e->board, "Checkerboard in view, inner corners, e.g. 8x6");
  CLI::Option* const square =
      options->add_option("--square-mm", e->square_mm, "Side of its squares")
          ->needs(board)
          ->check(between(1, 10000));
  board->needs(square);
  options->add_option("--aruco-mm", e->aruco_mm, "Side of an ArUco marker in view")
      ->check(between(1, 10000));
  options
      ->add_option("--aruco-dictionary", e->aruco_dictionary, "Its dictionary, as OpenCV calls it")
      ->needs("--aruco-mm")
      ->check(CLI::IsMember(aruco_dictionaries()).description("NAME"))
      ->capture_default_str();
  options->add_option("--apriltag-mm", e->apriltag_mm, "Side of an AprilTag (36h11) in view")
      ->check(between(1, 10000));
  options->add_option("--stills", e->stills, "List of photographs with their fingertips (CSV)");
  options->footer(kEvaluateExamples);
  return {options, [e] { return evaluate(*e); }};
}

}  // namespace handyar::cli
