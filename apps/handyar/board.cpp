// SPDX-License-Identifier: MIT
#include "handyar/calibration/board.hpp"

#include <filesystem>
#include <iostream>
#include <memory>

#include "command.hpp"
#include "handyar/calibration/board_sheet.hpp"
#include "handyar/io/pending_file.hpp"
#include "handyar/io/picture_file.hpp"

namespace handyar::cli {
namespace {

struct BoardRun {
  std::string out, squares = "9x7";
  double square_mm = 25;
};

int make_board(const BoardRun& run) {
  const auto squares = parse_grid(run.squares);
  if (!squares || squares->width < 4 || squares->height < 4)
    throw WrongUsage("--squares " + run.squares + " is not like 9x7, from 4x4 to 50x50");
  catch_interrupts();
  const Board board{squares->width - 1, squares->height - 1, run.square_mm / 1000};
  const bool printed = CLI::detail::to_lower(std::filesystem::path(run.out).extension()) == ".pdf";
  if (printed)
    io::write_text(run.out, board_pdf(board));
  else
    io::write_picture(run.out, board_image(board));
  std::cout << run.out << ": use it with --board " << board.columns << "x" << board.rows
            << " --square-mm "
            << (printed ? "and the side you measure on the print"
                        : "and the side you measure on the screen")
            << '\n';
  return kDone;
}

}  // namespace

Command add_board(CLI::App& app) {
  CLI::App* options = app.add_subcommand("board", "Make the checkerboard to print or to show");
  const auto run = std::make_shared<BoardRun>();
  options->add_option("--out", run->out, "Where to write it: .pdf in true size, or .png")
      ->required()
      ->check(ends_in({".pdf", ".png"}));
  options->add_option("--squares", run->squares, "Squares across and down")->capture_default_str();
  options->add_option("--square-mm", run->square_mm, "Side of a square, in print")
      ->check(between(1.0, 1000.0))
      ->capture_default_str();
  options->footer(
      "Examples:\n"
      "  handyar board --out board.pdf                   to print, squares of 25 mm\n"
      "  handyar board --out board.png --squares 7x5     to show on a screen");
  return {options, [run] { return make_board(*run); }};
}

}  // namespace handyar::cli
