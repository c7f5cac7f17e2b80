// SPDX-License-Identifier: MIT
#include "handyar/render/window.hpp"

#include <algorithm>
#include <utility>

#include "gl.hpp"
// GLFW after epoxy, which brings the OpenGL declarations.
#include <GLFW/glfw3.h>

#include "handyar/io/error.hpp"

namespace handyar::render {

namespace {

// What is free of panels, less some room for the window's own frame.
cv::Size free_of_screen() {
  constexpr double kFree = 0.94;
  int x = 0, y = 0, width = 0, height = 0;
  if (GLFWmonitor* const monitor = glfwGetPrimaryMonitor())
    glfwGetMonitorWorkarea(monitor, &x, &y, &width, &height);
  return {int(kFree * width), int(kFree * height)};
}

}  // namespace

cv::Size window_size(cv::Size picture_px, cv::Size free_px) {
  if (free_px.empty()) return picture_px;  // not known
  const double scale = std::min(
      {1.0, double(free_px.width) / picture_px.width, double(free_px.height) / picture_px.height});
  return {std::max(1, int(scale * picture_px.width)), std::max(1, int(scale * picture_px.height))};
}

struct Window::Painter {
  gl::Program program{
      R"(#version 140
uniform vec2 scale;
out vec2 uv;
void main() {
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
  uv = vec2(corner.x, 1.0 - corner.y);
  gl_Position = vec4(scale * (2.0 * corner - 1.0), 0.0, 1.0);
})",
      R"(#version 140
uniform sampler2D picture;
in vec2 uv;
out vec4 colour;
void main() { colour = vec4(texture(picture, uv).rgb, 1.0); })"};
  gl::VertexArray none;
  gl::Texture picture;
};

Window::Window(int width_px, int height_px, const std::string& title) {
  if (!glfwInit()) throw io::Error("--show", "there is no display to open a window on");
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 1);
  // EGL like the headless context: a thread cannot go from one of EGL to one of GLX.
  glfwWindowHint(GLFW_CONTEXT_CREATION_API, GLFW_EGL_CONTEXT_API);
  const cv::Size size = window_size({width_px, height_px}, free_of_screen());
  window_ = glfwCreateWindow(size.width, size.height, title.c_str(), nullptr, nullptr);
  if (!window_) {
    glfwTerminate();
    throw io::Error("--show", "this display offers no OpenGL 3.1");
  }
  glfwSetInputMode(window_, GLFW_STICKY_KEYS,
                   GLFW_TRUE);  // a short press between two frames counts
  glfwSetWindowUserPointer(window_, &typed_);
  glfwSetCharCallback(window_, [](GLFWwindow* window, unsigned character) {
    if (character < 0x80)
      *static_cast<std::string*>(glfwGetWindowUserPointer(window)) += char(character);
  });
  make_current();
  glfwSwapInterval(0);  // the camera sets the pace
  painter_ = std::make_unique<Painter>();
}

Window::~Window() {
  make_current();
  painter_.reset();
  glfwDestroyWindow(window_);
  glfwTerminate();
}

std::string Window::take_typed() { return std::exchange(typed_, {}); }

void Window::make_current() { glfwMakeContextCurrent(window_); }

bool Window::show(const cv::Mat& picture_bgr, double wait_s) {
  make_current();
  int width = 0, height = 0;
  glfwGetFramebufferSize(window_, &width, &height);
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_SCISSOR_TEST);
  glDisable(GL_BLEND);
  glViewport(0, 0, width, height);
  glClearColor(0, 0, 0, 1);
  glClear(GL_COLOR_BUFFER_BIT);

  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, painter_->picture);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glPixelStorei(GL_UNPACK_ROW_LENGTH, static_cast<GLint>(picture_bgr.step1() / 3));
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB8, picture_bgr.cols, picture_bgr.rows, 0, GL_BGR,
               GL_UNSIGNED_BYTE, picture_bgr.data);
  glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);

  const float aspect =
      (float(picture_bgr.cols) / picture_bgr.rows) / (float(width) / std::max(height, 1));
  painter_->program.use();
  glUniform2f(painter_->program["scale"], std::min(1.0f, aspect), std::min(1.0f, 1 / aspect));
  glBindVertexArray(painter_->none);
  glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
  glfwSwapBuffers(window_);
  glfwPollEvents();
  for (const double until_s = glfwGetTime() + wait_s; glfwGetTime() < until_s;)
    glfwWaitEventsTimeout(until_s - glfwGetTime());
  return !glfwWindowShouldClose(window_) && glfwGetKey(window_, GLFW_KEY_ESCAPE) != GLFW_PRESS &&
         glfwGetKey(window_, GLFW_KEY_Q) != GLFW_PRESS;
}

}  // namespace handyar::render
