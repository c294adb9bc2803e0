// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A linked program of OpenGL.
//
// Errors   kInternal with the compiler's or linker's own words
// Threads  that of the context
#ifndef LATTICED_TESTS_BENCH_PAPER_SHADERS_GL_PROGRAM_H_
#define LATTICED_TESTS_BENCH_PAPER_SHADERS_GL_PROGRAM_H_

#include <epoxy/gl.h>

#include <span>
#include <string>
#include <utility>

#include "absl/status/statusor.h"

namespace latticed::bench {

class GlProgram {
 public:
  struct Stage {
    GLenum kind;  // GL_VERTEX_SHADER …
    std::string text;
  };

  GlProgram() = default;
  // Transform feedback takes the outputs named in `captured`, interleaved.
  [[nodiscard]] static absl::StatusOr<GlProgram> Create(std::span<const Stage> stages,
                                                        std::span<const char* const> captured);
  ~GlProgram() { Reset(); }
  GlProgram(const GlProgram&) = delete;  // one owner
  GlProgram& operator=(const GlProgram&) = delete;
  GlProgram(GlProgram&& other) noexcept : id_(std::exchange(other.id_, 0)) {}
  GlProgram& operator=(GlProgram&& other) noexcept {
    if (this == &other) return *this;
    Reset();
    id_ = std::exchange(other.id_, 0);
    return *this;
  }

  GLuint id() const { return id_; }

 private:
  void Reset() {
    if (id_ != 0) glDeleteProgram(id_);
    id_ = 0;
  }

  GLuint id_ = 0;
};

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_PAPER_SHADERS_GL_PROGRAM_H_
