// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "html.hpp"

namespace handyar::evaluation::html {
namespace {

using nlohmann::json;

struct Series {
  const char* label;
  const char* column;  ///< of errors.csv
};

struct Chart {
  const char* title;
  const char* caption;
  const char* axis;
  std::vector<Series> series;
};

const std::array<Chart, 6>& all_charts() {
  static const std::array<Chart, 6> charts = {{
      {"Figure 8: reprojection error over time",
       "At the board's inner corners, rms a frame; transforms fitted on the other half of the "
       "frames.",
       "error (px)",
       {{"hand, raw", "board_raw_px"},
        {"hand, filtered", "board_filtered_px"},
        {"ArUco", "board_aruco_px"},
        {"AprilTag", "board_apriltag_px"}}},
      {"Fingertips",
       "Distance of each found fingertip from the true one.",
       "error (px)",
       {{"thumb", "thumb_px"},
        {"index", "index_px"},
        {"middle", "middle_px"},
        {"ring", "ring_px"},
        {"little", "little_px"}}},
      {"Rotation",
       "Angle between the pose and the true one.",
       "error (°)",
       {{"raw", "rotation_raw_deg"}, {"filtered", "rotation_deg"}}},
      {"Translation",
       "Distance between the pose's position and the true one.",
       "error (mm)",
       {{"raw", "translation_raw_mm"}, {"filtered", "translation_mm"}}},
      {"Residual",
       "Distance of the figure's outline from the picture's, rms a frame, outliers weighing less.",
       "residual (px)",
       {{"raw pose", "rms_px"}}},
      {"Time", "What the tracker took for each frame.", "time (ms)", {{"total", "total_ms"}}},
  }};
  return charts;
}

bool any_known(const std::vector<double>& values) {
  return std::any_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

/// The same six digits that errors.csv has; null where there is no value.
json json_values(const std::vector<double>& values) {
  json list = json::array();
  for (const double v : values)
    list.push_back(std::isfinite(v) ? json::parse(csv_number(v)) : json(nullptr));
  return list;
}

}  // namespace

std::string charts(const Analysis& a) {
  const ErrorColumns columns = error_columns(a);
  json data;
  data["states"] = columns.states;
  data["time_s"] = json_values(*columns.find("time_s"));
  data["charts"] = json::array();
  for (const Chart& chart : all_charts()) {
    json series = json::array();
    for (const Series& s : chart.series) {
      const std::vector<double>* values = columns.find(s.column);
      if (values && any_known(*values))
        series.push_back({{"label", s.label}, {"values", json_values(*values)}});
    }
    if (!series.empty())
      data["charts"].push_back({{"title", chart.title},
                                {"caption", chart.caption},
                                {"axis", chart.axis},
                                {"series", std::move(series)}});
  }
  std::string text = data.dump();
  // A "</" would end the script element early.
  for (std::size_t at = 0; (at = text.find("</", at)) != std::string::npos;)
    text.replace(at, 2, "<\\/");
  return "<div class=\"charts\"><script type=\"application/json\">" + text + "</script></div>\n";
}

}  // namespace handyar::evaluation::html
