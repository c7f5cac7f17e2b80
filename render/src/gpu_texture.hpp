// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <opencv2/core.hpp>

#include "gl.hpp"
#include "handyar/render/model.hpp"

namespace handyar::render {

/// A texture without mipmaps at `unit`, clamped at its edges, linearly read.
void upload(GLuint texture, int unit, GLint internal, int width, int height, GLenum format,
            GLenum type, const void* data);

using SharedTexture = std::shared_ptr<const gl::Texture>;

/// A picture (8-bit RGBA) with mipmaps; shrunk to what OpenGL takes.
SharedTexture uploaded(const cv::Mat& picture, Wrap wrap_u, Wrap wrap_v);

}  // namespace handyar::render
