// SPDX-License-Identifier: MIT
#include <cstdlib>

#include "annotated_list.hpp"
#include "handyar/io/error.hpp"
#include "memory_file.hpp"

namespace {

/// A fault that is told is none.
template <class Read>
void try_to(const Read& read) {
  try {
    read();
  } catch (const handyar::io::Error&) {
  }
}

}  // namespace

// A row of which the fingertips are read has finite ones, and a hand between them; frames count
// from 0.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace handyar;
  const fuzz::MemoryFile file(data, size);
  try_to([&] {
    const evaluation::AnnotatedList list(file.path());
    for (const auto& row : list.rows()) {
      try_to([&] {
        if (list.frame(row, "frame") < 0) std::abort();
      });
      try_to([&] { list.flag(row, "open"); });
      try_to([&] {
        const auto tips_px = list.tips_px(row);
        for (const Eigen::Vector2d& tip : tips_px)
          if (!tip.allFinite()) std::abort();
        if (!((tips_px.front() - tips_px.back()).norm() > 0)) std::abort();
      });
    }
  });
  return 0;
}
