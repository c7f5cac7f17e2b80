// SPDX-License-Identifier: MIT
#include "html.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace handyar::evaluation::html {
namespace {

/// A figure as a person wants it: about three digits that mean something.
std::string readable(double value) {
  if (!std::isfinite(value)) return "–";
  const double size = std::abs(value);
  const bool whole = value == std::round(value) && size < 1e6;
  char text[32];
  if (whole)
    std::snprintf(text, sizeof text, "%.0f", value);
  else if (size < 0.095 || size >= 1e6)
    std::snprintf(text, sizeof text, "%.2g", value);
  else
    std::snprintf(text, sizeof text, "%.*f", size >= 100 ? 1 : 2, value);
  return text;
}

std::vector<std::string> mentions(const Table& t, std::string Figure::*of) {
  std::vector<std::string> all;
  for (const Figure& f : t.figures)
    if (std::find(all.begin(), all.end(), f.*of) == all.end()) all.push_back(f.*of);
  return all;
}

/// The unit that all figures of a row or column share; "mixed" when they do not.
std::string shared_unit(const Table& t, std::string Figure::*of, const std::string& what) {
  std::string unit = "?";
  for (const Figure& f : t.figures) {
    if (f.*of != what || f.unit == unit) continue;
    if (unit != "?") return "mixed";
    unit = f.unit;
  }
  return unit;
}

std::string with_unit(const std::string& text, const std::string& unit) {
  if (unit.empty() || unit == "mixed") return escape(text);
  return escape(text) + " <small>" + escape(unit) + "</small>";
}

const Figure* find(const Table& t, const std::string& row, const std::string& column) {
  for (const Figure& f : t.figures)
    if (f.row == row && f.column == column) return &f;
  return nullptr;
}

}  // namespace

std::string escape(const std::string& text) {
  std::string out;
  for (const char c : text) switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  return out;
}

std::string table(const Table& t, int csv_line) {
  if (t.figures.empty()) return "";
  const std::vector<std::string> columns = mentions(t, &Figure::column);
  std::string h = "<figure class=\"table\"><figcaption><b>" + escape(t.title) + "</b> " +
                  escape(t.caption) +
                  "</figcaption><div class=\"wide\"><table><thead><tr><th></th>";
  for (const std::string& c : columns)
    h += "<th>" + with_unit(c, shared_unit(t, &Figure::column, c)) + "</th>";
  h += "</tr></thead><tbody>\n";
  for (const std::string& row : mentions(t, &Figure::row)) {
    h += "<tr><th>" + escape(row) + "</th>";
    for (const std::string& column : columns) {
      const Figure* f = find(t, row, column);
      if (!f) {
        h += "<td></td>";
        continue;
      }
      const auto line = csv_line + int(f - t.figures.data());
      const bool own_unit = shared_unit(t, &Figure::column, column) == "mixed";
      h += "<td title=\"tables.csv, line " + std::to_string(line) + "\">" + readable(f->value);
      if (own_unit && std::isfinite(f->value) && !f->unit.empty())
        h += " <small>" + escape(f->unit) + "</small>";
      h += "</td>";
    }
    h += "</tr>\n";
  }
  return h + "</tbody></table></div></figure>\n";
}

std::string pictures(const std::vector<Picture>& all, bool with_truth) {
  std::string h;
  for (const bool worst : {false, true}) {
    std::string group;
    for (const Picture& p : all)
      if (p.worst == worst)
        group += "<figure><img src=\"" + p.data_uri + "\" alt=\"" + escape(p.caption) +
                 "\"><figcaption>" + escape(p.caption) + "</figcaption></figure>\n";
    if (group.empty()) continue;
    h += std::string("<h4>") + (worst ? "The worst frames" : "Sample frames") + "</h4>";
    h += "<p>Hand contour cyan, fingertips orange, the hand's axes red, green, blue";
    h += with_truth ? "; white crosses: the true fingertips.</p>" : ".</p>";
    h += "<div class=\"pictures\">" + group + "</div>\n";
  }
  return h;
}

}  // namespace handyar::evaluation::html
