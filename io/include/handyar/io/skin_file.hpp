// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

#include "handyar/skin_model.hpp"

namespace handyar::io {

/// Reads a skin file (docs/formats.md). Everything is checked; throws Error naming file and fault.
/// Shares are scaled to add up to one.
SkinColors read_skin(const std::string& path);

/// The same from text; `name` stands for the file in messages.
SkinColors parse_skin(std::string_view text, std::string_view name);

std::string format_skin(const SkinColors& colors);
void write_skin(const std::string& path, const SkinColors& colors);

}  // namespace handyar::io
