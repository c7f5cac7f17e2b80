// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
#include <span>
#include <vector>

namespace handyar::evaluation {

/// What is said of a list of figures. Values that are not finite are left out of all of it.
struct Summary {
  int n = 0;
  double mean = std::numeric_limits<double>::quiet_NaN();
  double median = std::numeric_limits<double>::quiet_NaN();
  double p95 = std::numeric_limits<double>::quiet_NaN();
  double variance = std::numeric_limits<double>::quiet_NaN();  ///< divided by n, as the paper's
  double max = std::numeric_limits<double>::quiet_NaN();
};

Summary summarize(std::span<const double> values);

/// The p-th percentile (0 to 100) of ascending values, linear between neighbours; NaN of none.
double percentile(std::span<const double> ascending, double p);

}  // namespace handyar::evaluation
