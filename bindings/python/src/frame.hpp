// SPDX-License-Identifier: MIT
#pragma once

#include <pybind11/numpy.h>

#include <string>

#include "handyar/image_view.hpp"

namespace handyar::python {

namespace py = pybind11;

/// A numpy picture as it lies in memory; nothing is copied. `format` is "bgr", "rgb", "bgra" or
/// "rgba". Rows may lie anywhere; `frame[:, :, ::-1]` is read as what it is made from. Throws
/// TypeError or ValueError with what is wrong and what helps.
ImageView view_of(const py::object& frame, const std::string& format);

}  // namespace handyar::python
