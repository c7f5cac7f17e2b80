// SPDX-License-Identifier: MIT
#include "gl.hpp"

#include <stdexcept>

namespace handyar::render::gl {
namespace {

void attach(GLuint program, GLenum kind, const std::string& source) {
  const GLuint shader = glCreateShader(kind);
  const char* text = source.c_str();
  glShaderSource(shader, 1, &text, nullptr);
  glCompileShader(shader);
  GLint ok = 0;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &ok);
  char log[512] = "";
  if (!ok) glGetShaderInfoLog(shader, sizeof log, nullptr, log);
  glAttachShader(program, shader);
  glDeleteShader(shader);  // lives on as long as the program has it
  if (!ok) throw std::runtime_error(std::string("OpenGL refused a shader: ") + log);
}

}  // namespace

Program::Program(const std::string& vertex_source, const std::string& fragment_source,
                 std::span<const char* const> attributes) {
  attach(name_, GL_VERTEX_SHADER, vertex_source);
  attach(name_, GL_FRAGMENT_SHADER, fragment_source);
  for (GLuint location = 0; location < attributes.size(); ++location)
    glBindAttribLocation(name_, location, attributes[location]);
  glLinkProgram(name_);
  GLint ok = 0;
  glGetProgramiv(name_, GL_LINK_STATUS, &ok);
  if (ok) return;
  char log[512] = "";
  glGetProgramInfoLog(name_, sizeof log, nullptr, log);
  throw std::runtime_error(std::string("OpenGL refused a program: ") + log);
}

}  // namespace handyar::render::gl
