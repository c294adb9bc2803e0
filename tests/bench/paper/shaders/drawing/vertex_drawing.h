// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Draws vertices that are already in the device's memory: the column "drawing" of the paper's Table 3.
//
//   vertices   x y z nx ny nz in float32, patch by patch in pattern order (core/backend.h, kFloat32)
//   triangles  those of the pattern (tessellation_pattern.h), three indices of 32 bits each
//
// One draw call into a small picture without depth. Nothing is read back.
//
// Errors   kResourceExhausted, kInternal
// Threads  only the context's thread
#ifndef LATTICED_TESTS_BENCH_PAPER_SHADERS_DRAWING_VERTEX_DRAWING_H_
#define LATTICED_TESTS_BENCH_PAPER_SHADERS_DRAWING_VERTEX_DRAWING_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "tests/bench/gpu/gpu.h"
#include "tests/bench/paper/shaders/gl_objects.h"

namespace latticed::bench {

class VertexDrawing {
 public:
  static constexpr size_t kFloatsPerVertex = 6;

  // `vertices` holds whole patches. Needs a current context.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<VertexDrawing>> Create(
      std::span<const float> vertices, int segments);
  ~VertexDrawing();
  VertexDrawing(const VertexDrawing&) = delete;  // owns objects of OpenGL
  VertexDrawing& operator=(const VertexDrawing&) = delete;

  // Triangles that the device makes of one draw, by its own count.
  [[nodiscard]] size_t CountTriangles() const;
  // The picture shows points within `extent` of the origin on every axis.
  [[nodiscard]] absl::StatusOr<std::vector<uint8_t>> Draw(float extent);
  [[nodiscard]] absl::StatusOr<GpuTimes> TimeDrawn(float extent, int runs);

 private:
  VertexDrawing(GlProgram program, GlBuffer vertices, GlBuffer indices, size_t index_count);
  void DrawAll(float extent) const;

  GlProgram program_;
  GlBuffer vertices_, indices_;
  size_t index_count_;
  GlTarget target_;
  GLuint vertex_array_ = 0;
};

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_PAPER_SHADERS_DRAWING_VERTEX_DRAWING_H_
