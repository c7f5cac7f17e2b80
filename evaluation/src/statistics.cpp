// SPDX-License-Identifier: MIT
#include "handyar/evaluation/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace handyar::evaluation {

double percentile(std::span<const double> ascending, double p) {
  if (ascending.empty()) return std::numeric_limits<double>::quiet_NaN();
  const double at = p / 100.0 * double(ascending.size() - 1);
  const std::size_t below = std::size_t(at);
  const std::size_t above = std::min(below + 1, ascending.size() - 1);
  return std::lerp(ascending[below], ascending[above], at - double(below));
}

Summary summarize(std::span<const double> values) {
  std::vector<double> v;
  std::copy_if(values.begin(), values.end(), std::back_inserter(v),
               [](double x) { return std::isfinite(x); });
  Summary s;
  s.n = int(v.size());
  if (v.empty()) return s;
  std::sort(v.begin(), v.end());
  s.mean = std::accumulate(v.begin(), v.end(), 0.0) / double(v.size());
  s.median = percentile(v, 50);
  s.p95 = percentile(v, 95);
  s.max = v.back();
  s.variance =
      std::accumulate(v.begin(), v.end(), 0.0,
                      [&](double sum, double x) { return sum + (x - s.mean) * (x - s.mean); }) /
      double(v.size());
  return s;
}

}  // namespace handyar::evaluation
