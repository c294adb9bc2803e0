// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/paper/shaders/gl_objects.h"

#include <array>

#include "core/base/status_macros.h"
#include "tests/bench/paper/shaders/gl_context.h"

namespace latticed::bench {
namespace {

constexpr GLsizei kMostWords = 4'096;  // characters of a compiler's message

GLuint Created(const auto& create) {
  GLuint id = 0;
  create(1, &id);
  return id;
}

}  // namespace

absl::StatusOr<GlBuffer> GlBuffer::Create(size_t bytes, const void* from) {
  GlBuffer buffer;
  buffer.object_ = GlObject<Delete>(Created(glCreateBuffers));
  glNamedBufferStorage(buffer.id(), static_cast<GLsizeiptr>(bytes), from, 0);
  LATTICED_RETURN_IF_ERROR(GlStatus("a buffer"));
  return buffer;
}

void GlBuffer::Read(size_t bytes, void* to) const {
  glGetNamedBufferSubData(id(), 0, static_cast<GLsizeiptr>(bytes), to);
}

absl::StatusOr<GlProgram> GlProgram::Create(std::span<const Stage> stages,
                                            std::span<const char* const> captured) {
  GlProgram program;
  program.object_ = GlObject<Delete>(glCreateProgram());
  const GLuint id = program.id();
  std::array<char, kMostWords> words{};
  for (const Stage& stage : stages) {
    const GLuint shader = glCreateShader(stage.kind);
    const char* const text = stage.text.c_str();
    glShaderSource(shader, 1, &text, nullptr);
    glCompileShader(shader);
    GLint compiled = GL_FALSE;
    glGetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
    glGetShaderInfoLog(shader, kMostWords, nullptr, words.data());
    glAttachShader(id, shader);
    glDeleteShader(shader);  // deleted with the program
    if (compiled != GL_TRUE) return absl::InternalError(words.data());
  }
  if (!captured.empty()) {
    glTransformFeedbackVaryings(id, static_cast<GLsizei>(captured.size()), captured.data(),
                                GL_INTERLEAVED_ATTRIBS);
  }
  glLinkProgram(id);
  GLint linked = GL_FALSE;
  glGetProgramiv(id, GL_LINK_STATUS, &linked);
  glGetProgramInfoLog(id, kMostWords, nullptr, words.data());
  if (linked != GL_TRUE) return absl::InternalError(words.data());
  return program;
}

GlTarget::GlTarget(int size)
    : size_(size),
      framebuffer_(Created(glCreateFramebuffers)),
      pixels_(Created(glCreateRenderbuffers)) {
  glNamedRenderbufferStorage(pixels_.id(), GL_RGBA8, size, size);
  glNamedFramebufferRenderbuffer(framebuffer_.id(), GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER,
                                 pixels_.id());
}

void GlTarget::Bind() const {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
  glViewport(0, 0, size_, size_);
}

std::vector<uint8_t> GlTarget::Read() const {
  std::vector<uint8_t> pixels(4 * static_cast<size_t>(size_) * static_cast<size_t>(size_));
  Bind();
  glReadPixels(0, 0, size_, size_, GL_RGBA, GL_UNSIGNED_BYTE, pixels.data());
  return pixels;
}

GlQuery::GlQuery(GLenum counted)
    : counted_(counted),
      object_(Created([counted](GLsizei n, GLuint* id) { glCreateQueries(counted, n, id); })) {}

}  // namespace latticed::bench
