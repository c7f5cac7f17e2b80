// SPDX-License-Identifier: MIT
#include <cstdlib>

#include "annotated_list.hpp"
#include "handyar/io/error.hpp"
#include "memory_file.hpp"

// A row of which the fingertips are read has finite ones, and a hand between them.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace handyar;
  const fuzz::MemoryFile file(data, size);
  try {
    const evaluation::AnnotatedList list(file.path());
    for (const auto& row : list.rows()) {
      const auto tips_px = list.tips_px(row);
      for (const Eigen::Vector2d& tip : tips_px)
        if (!tip.allFinite()) std::abort();
      if (!((tips_px.front() - tips_px.back()).norm() > 0)) std::abort();
    }
  } catch (const io::Error&) {
  }
  return 0;
}
