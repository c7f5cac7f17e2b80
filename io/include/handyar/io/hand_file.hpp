// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

#include "handyar/hand_model.hpp"

namespace handyar::io {

/// Reads a hand file, version 1 to 4 (docs/formats.md). Everything is checked; throws Error naming
/// file and field.
HandModel read_hand(const std::string& path);

/// The same from text; `name` stands for the file in messages.
HandModel parse_hand(std::string_view text, std::string_view name);

/// As version 4.
std::string format_hand(const HandModel& hand);
void write_hand(const std::string& path, const HandModel& hand);

}  // namespace handyar::io
