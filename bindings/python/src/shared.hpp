// SPDX-License-Identifier: MIT
#pragma once

#include <pybind11/pybind11.h>

#include <mutex>
#include <utility>

namespace handyar::python {

namespace py = pybind11;

/// Something that works for long and that Python's threads may share: who comes while it works
/// waits, and the interpreter goes on meanwhile.
template <class T>
class Shared {
 public:
  explicit Shared(T value) : value_(std::move(value)) {}

  /// Calls `f` with it, which nobody else uses meanwhile. The interpreter's lock must not be held:
  /// who has it would wait for one who waits for it.
  template <class Function>
  auto alone(Function f) {
    const std::scoped_lock lock(mutex_);
    return f(value_);
  }

  /// The same from Python, whose lock is released: no Python in `f`.
  template <class Function>
  auto use(Function f) {
    const py::gil_scoped_release release;
    return alone(f);
  }

  /// The same with two of them, whoever else has them in the other order.
  template <class Function>
  static auto use_both(Shared& first, Shared& second, Function f) {
    const py::gil_scoped_release release;
    const std::scoped_lock lock(first.mutex_, second.mutex_);
    return f(first.value_, second.value_);
  }

 private:
  T value_;
  std::mutex mutex_;
};

}  // namespace handyar::python
