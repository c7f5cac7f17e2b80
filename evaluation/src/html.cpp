// SPDX-License-Identifier: MIT
#include "html.hpp"

#include "layout.hpp"

namespace handyar::evaluation::html {

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
  const auto small = [](const std::string& unit) {
    return unit.empty() ? "" : " <small>" + escape(unit) + "</small>";
  };
  const TableLayout layout = lay_out(t);
  std::string h = "<figure class=\"table\"><figcaption><b>" + escape(t.title) + "</b> " +
                  escape(t.caption) +
                  "</figcaption><div class=\"wide\"><table><thead><tr><th></th>";
  for (const TableLayout::Column& c : layout.columns)
    h += "<th>" + escape(c.title) + small(c.unit) + "</th>";
  h += "</tr></thead><tbody>\n";
  for (const TableLayout::Row& row : layout.rows) {
    h += "<tr><th>" + escape(row.title) + "</th>";
    for (const TableLayout::Cell& cell : row.cells)
      h += cell.text.empty()
               ? "<td></td>"
               : "<td title=\"tables.csv, line " + std::to_string(csv_line + cell.figure) + "\">" +
                     cell.text + small(cell.unit) + "</td>";
    h += "</tr>\n";
  }
  return h + "</tbody></table></div></figure>\n";
}

namespace {

std::string base64(const std::vector<unsigned char>& bytes) {
  static constexpr char kDigits[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned word = 0;
    for (std::size_t k = 0; k < 3; ++k)
      word = word << 8 | (i + k < bytes.size() ? bytes[i + k] : 0u);
    for (std::size_t k = 0; k < 4; ++k)
      text += i + k <= bytes.size() ? kDigits[word >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

}  // namespace

std::string pictures(const std::vector<Picture>& all, bool with_truth) {
  std::string h;
  for (const bool worst : {false, true}) {
    std::string group;
    for (const Picture& p : all)
      if (p.worst == worst)
        group += "<figure><img src=\"data:image/jpeg;base64," + base64(p.jpeg) + "\" alt=\"" +
                 escape(p.caption) + "\"><figcaption>" + escape(p.caption) +
                 "</figcaption></figure>\n";
    if (group.empty()) continue;
    h += std::string("<h4>") + (worst ? "The worst frames" : "Sample frames") + "</h4>";
    h += "<p>Hand contour cyan, fingertips orange, the hand's axes red, green, blue";
    h += with_truth ? "; white crosses: the true fingertips.</p>" : ".</p>";
    h += "<div class=\"pictures\">" + group + "</div>\n";
  }
  return h;
}

}  // namespace handyar::evaluation::html
