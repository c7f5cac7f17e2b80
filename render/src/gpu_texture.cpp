// SPDX-License-Identifier: MIT
#include "gpu_texture.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace handyar::render {
namespace {

GLint mode_of(Wrap wrap) {
  if (wrap == Wrap::mirror) return GL_MIRRORED_REPEAT;
  return wrap == Wrap::repeat ? GL_REPEAT : GL_CLAMP_TO_EDGE;
}

}  // namespace

void upload(GLuint texture, int unit, GLint internal, int width, int height, GLenum format,
            GLenum type, const void* data) {
  glActiveTexture(GL_TEXTURE0 + unit);
  glBindTexture(GL_TEXTURE_2D, texture);
  for (GLenum wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
    glTexParameteri(GL_TEXTURE_2D, wrap, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexImage2D(GL_TEXTURE_2D, 0, internal, width, height, 0, format, type, data);
}

SharedTexture uploaded(const cv::Mat& picture, Wrap wrap_u, Wrap wrap_v) {
  GLint most_px = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &most_px);
  cv::Mat rgba = picture.isContinuous() ? picture : picture.clone();
  if (std::max(rgba.cols, rgba.rows) > most_px)
    cv::resize(picture, rgba, {std::min(rgba.cols, most_px), std::min(rgba.rows, most_px)}, 0, 0,
               cv::INTER_AREA);
  auto texture = std::make_shared<gl::Texture>();
  upload(*texture, 0, GL_RGBA8, rgba.cols, rgba.rows, GL_RGBA, GL_UNSIGNED_BYTE, rgba.data);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, mode_of(wrap_u));
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, mode_of(wrap_v));
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  glGenerateMipmap(GL_TEXTURE_2D);
  return texture;
}

}  // namespace handyar::render
