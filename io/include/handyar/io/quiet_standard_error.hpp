// SPDX-License-Identifier: MIT
#pragma once

namespace handyar::io {

/// Nothing goes to standard error while one lives, in any thread. libpng and libjpeg complain there
/// directly when a picture is decoded; no setting of OpenCV's stops that.
class QuietStandardError {
 public:
  QuietStandardError();
  ~QuietStandardError();
  QuietStandardError(const QuietStandardError&) = delete;
  QuietStandardError& operator=(const QuietStandardError&) = delete;
};

}  // namespace handyar::io
