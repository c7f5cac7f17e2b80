// SPDX-License-Identifier: MIT
#pragma once

#include <memory>

namespace handyar::render {

/// An OpenGL context of version 3.1 or newer, what the graphics of a Raspberry Pi 4 offer; current
/// on the thread that made it until another is made current.
class Context {
 public:
  virtual ~Context() = default;
  virtual void make_current() = 0;

 protected:
  Context() = default;
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;
};

/// A context that needs no display (EGL without a surface; with Mesa also without a GPU). Throws
/// io::Error when the machine offers none.
std::shared_ptr<Context> headless_context();

}  // namespace handyar::render
