// SPDX-License-Identifier: MIT
#include "handyar/render/context.hpp"

#include <epoxy/egl.h>

#include "handyar/io/error.hpp"

namespace handyar::render {
namespace {

class HeadlessContext final : public Context {
 public:
  HeadlessContext() {
    open_display();
    const EGLint config_attributes[] = {EGL_SURFACE_TYPE, 0,  // none is needed
                                        EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
    EGLConfig config = nullptr;
    EGLint count = 0;
    eglChooseConfig(display_, config_attributes, &config, 1, &count);
    const EGLint context_attributes[] = {EGL_CONTEXT_MAJOR_VERSION, 3, EGL_CONTEXT_MINOR_VERSION, 1,
                                         EGL_NONE};
    if (count > 0 && eglBindAPI(EGL_OPENGL_API))
      context_ = eglCreateContext(display_, config, EGL_NO_CONTEXT, context_attributes);
    if (context_ == EGL_NO_CONTEXT) {
      eglTerminate(display_);
      throw io::Error("OpenGL", "this machine offers no OpenGL 3.1 through EGL");
    }
    make_current();
  }

  ~HeadlessContext() override {
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(display_, context_);
    // The display is shared by the whole process: other contexts may still live on it.
  }

  void make_current() override {
    if (!eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_))
      throw io::Error("OpenGL", "EGL offers no context without a surface here");
  }

 private:
  void open_display() {
    if (epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_MESA_platform_surfaceless"))
      display_ =
          eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
    if (display_ == EGL_NO_DISPLAY || !eglInitialize(display_, nullptr, nullptr)) {
      display_ = eglGetDisplay(EGL_DEFAULT_DISPLAY);
      if (display_ == EGL_NO_DISPLAY || !eglInitialize(display_, nullptr, nullptr))
        throw io::Error("OpenGL", "EGL finds no display to draw without a screen");
    }
  }

  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLContext context_ = EGL_NO_CONTEXT;
};

}  // namespace

std::shared_ptr<Context> headless_context() { return std::make_shared<HeadlessContext>(); }

}  // namespace handyar::render
