// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace handyar::io {

/// True when a video file (MP4, MOV, AVI, Matroska, WebM) ends before the length that its own
/// headers state. The number of frames that a container promises cannot tell: it is an estimate in
/// AVI and Matroska, and after a lossless cut an MP4 counts frames that are not to be shown.
bool is_cut_short(const std::string& path);

/// True when in an AVI, Matroska or WebM one part does not follow the other: their readers go on at
/// the next that they find, and say nothing.
bool is_chain_broken(const std::string& path);

/// True for an MP4 or MOV whose one index lists every frame: one that cannot be found is lost.
bool indexes_every_frame(const std::string& path);

/// True when the file begins like text: FFmpeg would show it as a picture of its letters, or follow
/// the addresses in a play list.
bool looks_like_text(const std::string& path);

}  // namespace handyar::io
