// SPDX-License-Identifier: MIT
#pragma once

#include <epoxy/gl.h>

#include <span>
#include <string>
#include <utility>

namespace handyar::render::gl {

/// Owns one OpenGL name; `Make` and `Free` are glGen*- and glDelete*-like.
template <typename Traits>
class Name {
 public:
  Name() { Traits::make(&id_); }
  ~Name() {
    if (id_) Traits::free(&id_);
  }
  Name(Name&& other) noexcept : id_(std::exchange(other.id_, 0)) {}
  Name& operator=(Name&& other) noexcept {
    std::swap(id_, other.id_);
    return *this;
  }
  operator GLuint() const noexcept { return id_; }

 private:
  GLuint id_ = 0;
};

struct BufferTraits {
  static void make(GLuint* id) { glGenBuffers(1, id); }
  static void free(GLuint* id) { glDeleteBuffers(1, id); }
};
struct VertexArrayTraits {
  static void make(GLuint* id) { glGenVertexArrays(1, id); }
  static void free(GLuint* id) { glDeleteVertexArrays(1, id); }
};
struct TextureTraits {
  static void make(GLuint* id) { glGenTextures(1, id); }
  static void free(GLuint* id) { glDeleteTextures(1, id); }
};
struct RenderbufferTraits {
  static void make(GLuint* id) { glGenRenderbuffers(1, id); }
  static void free(GLuint* id) { glDeleteRenderbuffers(1, id); }
};
struct FramebufferTraits {
  static void make(GLuint* id) { glGenFramebuffers(1, id); }
  static void free(GLuint* id) { glDeleteFramebuffers(1, id); }
};
struct ProgramTraits {
  static void make(GLuint* id) { *id = glCreateProgram(); }
  static void free(GLuint* id) { glDeleteProgram(*id); }
};

using Buffer = Name<BufferTraits>;
using VertexArray = Name<VertexArrayTraits>;
using Texture = Name<TextureTraits>;
using Renderbuffer = Name<RenderbufferTraits>;
using Framebuffer = Name<FramebufferTraits>;

/// A linked pair of shaders. Throws std::runtime_error with the compiler's first words.
class Program {
 public:
  /// `attributes`: of the vertex shader, which get the locations 0, 1, ...
  Program(const std::string& vertex_source, const std::string& fragment_source,
          std::span<const char* const> attributes = {});
  void use() const { glUseProgram(name_); }
  /// Location of a uniform; -1 when the compiler dropped it, which OpenGL ignores.
  GLint operator[](const char* uniform) const { return glGetUniformLocation(name_, uniform); }

 private:
  Name<ProgramTraits> name_;
};

}  // namespace handyar::render::gl
