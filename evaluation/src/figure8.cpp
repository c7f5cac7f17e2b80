// SPDX-License-Identifier: MIT
#include "figure8.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>

#include "handyar/evaluation/statistics.hpp"
#include "handyar/evaluation/tables.hpp"
#include "handyar/io/pending_file.hpp"

namespace handyar::evaluation {
namespace {

struct Curve {
  const char* column;
  const char* label;
  const char* color;
};
constexpr std::array<Curve, 4> kCurves = {{{"board_raw_px", "hand, raw", "#c9b8ef"},
                                           {"board_filtered_px", "hand, filtered", "#5b2fc0"},
                                           {"board_aruco_px", "ArUco", "#d55e00"},
                                           {"board_apriltag_px", "AprilTag", "#009e73"}}};

std::string quoted(const std::string& text) {
  std::string q = "'";
  for (const char c : text) q += c == '\'' ? std::string("''") : std::string(1, c);
  return q + "'";
}

std::string shell_quoted(const std::string& text) {
  std::string q = "'";
  for (const char c : text) q += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return q + "'";
}

/// Errors above this are cut off, so that one lost frame does not flatten everything else.
double most_shown(const ErrorColumns& columns) {
  double most = 1;
  for (const Curve& c : kCurves)
    if (const auto* v = columns.find(c.column)) {
      const Summary s = summarize(*v);
      if (s.n > 0) most = std::max(most, std::min(s.max, 2.5 * s.p95));
    }
  return 1.05 * most;
}

std::string script(const ErrorColumns& columns, const std::string& title, const std::string& png) {
  std::string data = "$errors << EOD\n";
  const std::vector<double>& time_s = *columns.find("time_s");
  for (std::size_t i = 0; i < time_s.size(); ++i) {
    data += csv_number(time_s[i]) + " " + columns.states[i];
    for (const Curve& c : kCurves) {
      const double v = (*columns.find(c.column))[i];
      data += " " + (std::isfinite(v) ? csv_number(v) : "NaN");
    }
    data += "\n";
  }
  data += "EOD\n";
  std::string s =
      "set terminal pngcairo size 1200,560 font 'sans,11'\nset output " + quoted(png) + "\n" +
      data +
      "set multiplot\nset lmargin 9\nset rmargin 3\nset tmargin 2.5\nset bmargin 0\n"
      "set origin 0,0.22\nset size 1,0.78\nset grid lc rgb '#dddddd'\n"
      "set key top right horizontal\nset format x ''\nset ylabel 'reprojection error (px)'\n"
      "set title " +
      quoted(title) +
      " noenhanced\n"
      "set yrange [0:" +
      csv_number(most_shown(columns)) + "]\nset xrange [" + csv_number(time_s.front()) + ":" +
      csv_number(time_s.back() + 1e-3) + "]\nplot ";
  for (std::size_t i = 0; i < kCurves.size(); ++i)
    s += std::string(i ? ", " : "") + "$errors using 1:" + std::to_string(i + 3) +
         " with lines lw 1.5 lc rgb '" + kCurves[i].color + "' title '" + kCurves[i].label + "'";
  s += "\nset origin 0,0\nset size 1,0.22\nset tmargin 0.6\nset bmargin 3.2\nunset title\nunset "
       "key\n"
       "set format x\nset xlabel 'time (s)'\nset ylabel 'state'\nset yrange [0:5]\n"
       "set ytics ('searching' 1, 'acquiring' 2, 'tracking' 3, 'lost' 4) font ',8'\n"
       "level(s) = s eq 'searching' ? 1 : s eq 'acquiring' ? 2 : s eq 'tracking' ? 3 : 4\n"
       "plot $errors using 1:(level(strcol(2))) with points pt 5 ps 0.5 lc rgb '#333333'\n"
       "unset multiplot\nset output\n";
  return s;
}

}  // namespace

bool draw_figure8(const Analysis& analysis, const std::string& file) {
  io::PendingFile png(file);
  const io::PendingFile commands(file + ".gnuplot");
  std::ofstream(commands.path()) << script(
      error_columns(analysis), "Figure 8: " + analysis.recording.sequence.name, png.path());
  const std::string run = "gnuplot " + shell_quoted(commands.path()) + " >/dev/null 2>&1";
  if (std::system(run.c_str()) != 0) return false;
  png.commit();
  return true;
}

}  // namespace handyar::evaluation
