// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "handyar/io/frame_source.hpp"

namespace handyar::io {

std::unique_ptr<FrameSource> open_video(const std::string& path);
/// `pattern` is a picture's path, or holds one %d or %0Nd.
std::unique_ptr<FrameSource> open_pictures(const std::string& pattern);
std::unique_ptr<FrameSource> open_camera(const std::string& device);

bool is_picture(const std::string& path);
/// Whether the file name holds a %d or %0Nd.
bool is_picture_pattern(const std::string& path);

/// How many frames are found in a video file, `most` at most, without decoding any.
std::int64_t count_packets(const std::string& path, std::int64_t most);

/// Throws Error when HandTracker does not take such frames.
void require_usable(const Frame& frame, const std::string& name);
/// Throws Error when the frame's size is not the source's.
void require_same_size(const Frame& frame, const SourceInfo& info);

/// OpenCV and FFmpeg write to standard error on their own; this ends that. What they would say
/// comes as an Error instead. Called before they are first used.
void silence_libraries();

}  // namespace handyar::io
