// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "handyar/io/frame_source.hpp"

namespace handyar::io {

class DriverCalls;

std::unique_ptr<FrameSource> open_video(const std::string& path);
/// `pattern` is a picture's path, or holds one %d or %0Nd.
std::unique_ptr<FrameSource> open_pictures(const std::string& pattern);
std::unique_ptr<FrameSource> open_camera(const std::string& device, const CameraSettings& settings);
/// The same with a driver that answers these calls.
std::unique_ptr<FrameSource> open_camera(const std::string& device, const CameraSettings& settings,
                                         DriverCalls& calls);

bool is_picture(const std::string& path);
/// Whether the file name holds a %d or %0Nd.
bool is_picture_pattern(const std::string& path);

/// The whole number by which sides are divided so that HandTracker takes the picture.
int reduction(const cv::Mat& picture);
void reduce(cv::Mat& picture, int by);

/// Throws Error when HandTracker does not take frames of such a size.
void require_usable(const Frame& frame, const std::string& name, int reduced_by = 1);
/// Throws Error when the frame's size is not the source's.
void require_same_size(const Frame& frame, const SourceInfo& info);

/// OpenCV and FFmpeg write to standard error on their own; this ends that. What they would say
/// comes as an Error instead. Called before they are first used.
void silence_libraries();

}  // namespace handyar::io
