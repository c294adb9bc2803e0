// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A square picture to draw into, four bytes a pixel.
//
// Errors   kInternal, kResourceExhausted
// Threads  that of the context
#ifndef LATTICED_TESTS_BENCH_PAPER_SHADERS_GL_TARGET_H_
#define LATTICED_TESTS_BENCH_PAPER_SHADERS_GL_TARGET_H_

#include <epoxy/gl.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "core/base/status_macros.h"
#include "tests/bench/paper/shaders/gl_context.h"

namespace latticed::bench {

class GlTarget {
 public:
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<GlTarget>> Create(int size) {
    std::unique_ptr<GlTarget> target(new GlTarget(size));
    LATTICED_RETURN_IF_ERROR(GlStatus("a picture"));
    return target;
  }
  ~GlTarget() {
    glDeleteFramebuffers(1, &framebuffer_);
    glDeleteRenderbuffers(1, &pixels_);
  }
  GlTarget(const GlTarget&) = delete;  // one owner
  GlTarget& operator=(const GlTarget&) = delete;

  // What is drawn next goes here.
  void Bind() const {
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
    glViewport(0, 0, size_, size_);
  }
  void Clear() const {
    Bind();
    glClear(GL_COLOR_BUFFER_BIT);
  }

  // Red, green, blue, alpha; waits for what was drawn.
  std::vector<uint8_t> Read() const {
    std::vector<uint8_t> pixels(4 * static_cast<size_t>(size_) * static_cast<size_t>(size_));
    Bind();
    glReadPixels(0, 0, size_, size_, GL_RGBA, GL_UNSIGNED_BYTE, pixels.data());
    return pixels;
  }

 private:
  explicit GlTarget(int size) : size_(size) {
    glCreateRenderbuffers(1, &pixels_);
    glNamedRenderbufferStorage(pixels_, GL_RGBA8, size, size);
    glCreateFramebuffers(1, &framebuffer_);
    glNamedFramebufferRenderbuffer(framebuffer_, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, pixels_);
  }

  GLsizei size_;
  GLuint framebuffer_ = 0, pixels_ = 0;
};

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_PAPER_SHADERS_GL_TARGET_H_
