// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string>

namespace handyar::evaluation {

/// As many pictures, worst-1.jpg and so on, a tree's report has.
inline constexpr std::size_t kWorstShown = 5;

/// Removes from the folder the files that earlier runs wrote as their reports, so that what lies in
/// it is of one run. They are known by their names and by how their lists begin: anything else, and
/// a person's own file of the same name, stays. Throws io::Error.
void remove_earlier_report(const std::string& folder);

}  // namespace handyar::evaluation
