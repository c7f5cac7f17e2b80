// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace handyar::evaluation {

/// Processor and operating system, for a reader: "AMD EPYC 7763, 2 cores, Linux 6.1 x86_64".
std::string describe_machine();

/// "g++ 12.2.0, OpenCV 4.6.0, Eigen 3.4.0"
std::string describe_build();

/// Now, as "2026-01-31 14:05 UTC".
std::string describe_now();

}  // namespace handyar::evaluation
