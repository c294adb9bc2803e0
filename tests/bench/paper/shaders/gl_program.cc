// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/paper/shaders/gl_program.h"

#include <array>

namespace latticed::bench {
namespace {

constexpr GLsizei kMostWords = 4'096;  // of a compiler

}  // namespace

absl::StatusOr<GlProgram> GlProgram::Create(std::span<const Stage> stages,
                                            std::span<const char* const> captured) {
  GlProgram program;
  program.id_ = glCreateProgram();
  std::array<char, kMostWords> words{};
  for (const Stage& stage : stages) {
    const GLuint shader = glCreateShader(stage.kind);
    const char* const text = stage.text.c_str();
    glShaderSource(shader, 1, &text, nullptr);
    glCompileShader(shader);
    GLint compiled = GL_FALSE;
    glGetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
    glGetShaderInfoLog(shader, kMostWords, nullptr, words.data());
    glAttachShader(program.id_, shader);
    glDeleteShader(shader);  // goes with the program
    if (compiled != GL_TRUE) return absl::InternalError(words.data());
  }
  if (!captured.empty()) {
    glTransformFeedbackVaryings(program.id_, static_cast<GLsizei>(captured.size()), captured.data(),
                                GL_INTERLEAVED_ATTRIBS);
  }
  glLinkProgram(program.id_);
  GLint linked = GL_FALSE;
  glGetProgramiv(program.id_, GL_LINK_STATUS, &linked);
  glGetProgramInfoLog(program.id_, kMostWords, nullptr, words.data());
  if (linked != GL_TRUE) return absl::InternalError(words.data());
  return program;
}

}  // namespace latticed::bench
