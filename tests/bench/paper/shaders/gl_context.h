// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// OpenGL 4.5 without a window: a surfaceless context on an EGL device.
//                                 EGL_EXT_device_enumeration, EGL_EXT_platform_device
//
// libEGL and libOpenGL (or libGL) are the system's. They are opened when the first context is made,
// so a program that links this also runs where they are missing.
//
// All contexts of a device share its display, which stays open until the process ends.
//
// Errors   kUnavailable, naming what is missing
// Threads  a context is used only on the thread that made it
#ifndef LATTICED_TESTS_BENCH_PAPER_SHADERS_GL_CONTEXT_H_
#define LATTICED_TESTS_BENCH_PAPER_SHADERS_GL_CONTEXT_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "tests/bench/paper/shaders/shader_device.h"

namespace latticed::bench {

class GlContext {
 public:
  // Uses the first device that matches `wanted` and has OpenGL 4.5. The context is current afterwards.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<GlContext>> Create(ShaderDevice wanted);
  ~GlContext();
  GlContext(const GlContext&) = delete;  // owns the context
  GlContext& operator=(const GlContext&) = delete;

  [[nodiscard]] absl::Status MakeCurrent() const;

  // "NVIDIA H200/PCIe/SSE2, 4.6.0 NVIDIA 580.00".
  const std::string& description() const { return description_; }

 private:
  GlContext(void* display, void* context) : display_(display), context_(context) {}
  // Makes a context on one EGL device.
  static absl::StatusOr<std::unique_ptr<GlContext>> Make(void* device);

  void* display_;
  void* context_;
  std::string description_;
};

// kInternal or kResourceExhausted, with `what`, if OpenGL has recorded an error since the last call.
[[nodiscard]] absl::Status GlStatus(const char* what);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_PAPER_SHADERS_GL_CONTEXT_H_
