// SPDX-License-Identifier: MIT
#include "handyar/calibration/board_sheet.hpp"

#include <array>
#include <charconv>
#include <vector>

#include "handyar/calibration/error.hpp"
#include "text.hpp"

namespace handyar {
namespace {

constexpr double kPointsPerMm = 72 / 25.4;  // PDF's unit of length
constexpr double kMargin_mm = 10;

struct Page {
  double width_mm, height_mm;
};

Page page_for(double width_mm, double height_mm) {
  for (const Page& paper : {Page{297, 210}, Page{420, 297}})
    if (width_mm + 2 * kMargin_mm <= paper.width_mm &&
        height_mm + 2 * kMargin_mm <= paper.height_mm)
      return paper;
  return {width_mm + 2 * kMargin_mm, height_mm + 2 * kMargin_mm};
}

bool black(int column, int row) { return (column + row) % 2 == 0; }

// With a point in every locale, as PDF has it.
std::string number(double value, std::chars_format format, int digits) {
  char buffer[64];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, value, format, digits).ptr;
  return {buffer, end};
}
std::string fixed(double value, int digits) {
  return number(value, std::chars_format::fixed, digits);
}
std::string short_mm(double value_mm) { return number(value_mm, std::chars_format::general, 4); }

// Page contents in PDF's drawing language; millimetres by the matrix of the first line.
std::string drawing(const Board& board, const Page& page) {
  const int columns = board.columns + 1, rows = board.rows + 1;
  const double side_mm = 1000 * board.square_m;
  const double left = (page.width_mm - columns * side_mm) / 2;
  const double bottom = (page.height_mm - rows * side_mm) / 2;
  const std::string scale = fixed(kPointsPerMm, 8), side = fixed(side_mm, 4);
  std::string s = scale + " 0 0 " + scale + " 0 0 cm\n0 g\n";
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i)
      if (black(i, j))
        s += fixed(left + i * side_mm, 4) + " " + fixed(bottom + j * side_mm, 4) + " " + side +
             " " + side + " re\n";
  return s + "f\nBT /F1 3 Tf " + fixed(left, 2) + " " + fixed(bottom - 6, 2) +
         " Td (handyar board: --board " + std::to_string(board.columns) + "x" +
         std::to_string(board.rows) + " --square-mm " + short_mm(side_mm) +
         ". Print at 100 %; check: " + std::to_string(columns) + " squares are " +
         short_mm(columns * side_mm) + " mm wide.) Tj ET\n";
}

}  // namespace

std::string board_pdf(const Board& board) {
  const double side_mm = 1000 * board.square_m;
  const Page page = page_for((board.columns + 1) * side_mm, (board.rows + 1) * side_mm);
  const std::string contents = drawing(board, page);
  const std::array<std::string, 5> objects = {
      "<< /Type /Catalog /Pages 2 0 R /ViewerPreferences << /PrintScaling /None >> >>",
      "<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
      "<< /Type /Page /Parent 2 0 R /MediaBox [0 0 " + fixed(page.width_mm * kPointsPerMm, 4) +
          " " + fixed(page.height_mm * kPointsPerMm, 4) +
          "] /Contents 4 0 R /Resources << /Font << /F1 5 0 R >> >> >>",
      text("<< /Length %zu >>\nstream\n", contents.size()) + contents + "endstream",
      "<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica >>"};
  std::string pdf = "%PDF-1.6\n";
  std::string table = text("xref\n0 %zu\n0000000000 65535 f \n", objects.size() + 1);
  for (std::size_t i = 0; i < objects.size(); ++i) {
    table += text("%010zu 00000 n \n", pdf.size());
    pdf += text("%zu 0 obj\n", i + 1) + objects[i] + "\nendobj\n";
  }
  const std::size_t table_at = pdf.size();
  return pdf + table +
         text("trailer\n<< /Size %zu /Root 1 0 R >>\nstartxref\n%zu\n%%%%EOF\n", objects.size() + 1,
              table_at);
}

cv::Mat board_image(const Board& board, int square_px) {
  const int columns = board.columns + 1, rows = board.rows + 1;
  const double pixels = double(columns + 2) * (rows + 2) * square_px * square_px;
  if (pixels > 1e8) throw CalibrationError("the board would have more than 100 million pixels");
  cv::Mat image((rows + 2) * square_px, (columns + 2) * square_px, CV_8U, cv::Scalar(255));
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i)
      if (black(i, j))
        image(cv::Rect((i + 1) * square_px, (j + 1) * square_px, square_px, square_px)).setTo(0);
  return image;
}

}  // namespace handyar
