// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Memory of the OpenGL device, of a size that stays.
//
// Errors   kResourceExhausted, kInternal
// Threads  that of the context
#ifndef LATTICED_TESTS_BENCH_PAPER_SHADERS_GL_BUFFER_H_
#define LATTICED_TESTS_BENCH_PAPER_SHADERS_GL_BUFFER_H_

#include <epoxy/gl.h>

#include <cstddef>
#include <utility>

#include "core/base/status_macros.h"
#include "tests/bench/paper/shaders/gl_context.h"

namespace latticed::bench {

class GlBuffer {
 public:
  GlBuffer() = default;
  // A copy of `bytes` bytes at `from`; not initialised where that is null.
  [[nodiscard]] static absl::StatusOr<GlBuffer> Create(size_t bytes, const void* from) {
    GlBuffer buffer;
    glCreateBuffers(1, &buffer.id_);
    buffer.bytes_ = bytes;
    glNamedBufferStorage(buffer.id_, static_cast<GLsizeiptr>(bytes), from, 0);
    LATTICED_RETURN_IF_ERROR(GlStatus("a buffer"));
    return buffer;
  }
  ~GlBuffer() { Reset(); }
  GlBuffer(const GlBuffer&) = delete;  // one owner
  GlBuffer& operator=(const GlBuffer&) = delete;
  GlBuffer(GlBuffer&& other) noexcept
      : id_(std::exchange(other.id_, 0)), bytes_(std::exchange(other.bytes_, 0)) {}
  GlBuffer& operator=(GlBuffer&& other) noexcept {
    if (this == &other) return *this;
    Reset();
    id_ = std::exchange(other.id_, 0);
    bytes_ = std::exchange(other.bytes_, 0);
    return *this;
  }

  GLuint id() const { return id_; }
  size_t bytes() const { return bytes_; }

  // The first `bytes` bytes; waits for what was drawn before.
  void Read(size_t bytes, void* to) const {
    glGetNamedBufferSubData(id_, 0, static_cast<GLsizeiptr>(bytes), to);
  }

 private:
  void Reset() {
    if (id_ != 0) glDeleteBuffers(1, &id_);
    id_ = 0;
  }

  GLuint id_ = 0;
  size_t bytes_ = 0;
};

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_PAPER_SHADERS_GL_BUFFER_H_
