// SPDX-License-Identifier: MIT
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

namespace handyar::io {

/// What everything in handyar::io throws. `what()` is one line for a person that names the file or
/// device and what is wrong with it: "camera.yml: image_width is missing".
class Error : public std::runtime_error {
 public:
  Error(std::string_view subject, std::string_view fault);
};

/// A signal came while a pipe waited for its reader.
class Interrupted : public Error {
  using Error::Error;
};

}  // namespace handyar::io
