// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The tessellation-shader algorithm, from control points to vertices.
//                                        Cui & Feng 2014, doi:10.1007/s11766-014-3239-6, Table 3
//
//   nets -> GL_PATCHES -> control shader: levels -> tessellator -> evaluation shader
//        -> transform feedback: positions and normals, 24 bytes a vertex
//        or -> a small picture
//
// OpenGL's pattern differs from the paper's: at level 10 a patch has 150 triangles with 91 distinct
// points, the paper's has 100 with 66. Transform feedback writes three vertices per triangle.
// Patches are captured in batches that fit a buffer, and each batch overwrites the previous one.
// This measures the bandwidth for all patches without their memory.
//
// The timed program is the one that Capture runs for positions and normals. Coordinates and patch
// numbers, which no user of the algorithm captures, come from a second program. It has the same
// shaders and gives vertices in the same order.
//
// Errors   kInternal, kResourceExhausted; kInvalidArgument if a net has too many vertices
// Threads  only the context's thread
#ifndef LATTICED_TESTS_BENCH_PAPER_SHADERS_SHADER_TESSELLATOR_H_
#define LATTICED_TESTS_BENCH_PAPER_SHADERS_SHADER_TESSELLATOR_H_

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "tests/bench/gpu/gpu.h"
#include "tests/bench/paper/bezier_net/bezier_net.h"
#include "tests/bench/paper/shaders/bezier_shaders.h"
#include "tests/bench/paper/shaders/gl_objects.h"
#include "tests/bench/paper/shaders/shader_vertex.h"

namespace latticed::bench {

class ShaderTessellator {
 public:
  struct Spec {
    int degree = 6;
    int level = 10;
    NetSource source = NetSource::kBuffer;
    size_t capture_bytes = size_t{1} << 30;  // at most, per batch
  };
  // `nets` has the layout of bezier_net.h. Needs a current context.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<ShaderTessellator>> Create(
      const Spec& spec, std::span<const NetPoint> nets);
  ~ShaderTessellator();
  ShaderTessellator(const ShaderTessellator&) = delete;  // owns objects of OpenGL
  ShaderTessellator& operator=(const ShaderTessellator&) = delete;

  size_t patches() const { return patches_; }
  size_t triangles_per_patch() const { return triangles_; }
  size_t batch_patches() const { return batch_; }

  // Three vertices per triangle of patches [first, first + count), in the device's order.
  [[nodiscard]] absl::StatusOr<std::vector<ShaderVertex>> Capture(size_t first, size_t count);
  // Draws all patches. The picture shows points within `extent` of the origin on every axis.
  [[nodiscard]] absl::StatusOr<std::vector<uint8_t>> Draw(float extent);

  // Times all patches, as time_commands.h says.
  [[nodiscard]] absl::StatusOr<GpuTimes> TimeCaptured(int runs);
  [[nodiscard]] absl::StatusOr<GpuTimes> TimeDrawn(float extent, int runs);

 private:
  struct Programs {
    GlProgram captured, probe, drawn;
  };

  ShaderTessellator(const Spec& spec, size_t patches, Programs programs, GlBuffer nets);
  absl::Status MakeCaptureBuffers();
  int PatchVertices() const;
  void Use(const GlProgram& program) const;
  void DrawPatches(size_t first, size_t count) const;
  void CapturePatches(const GlProgram& program, const GlBuffer& to, size_t first,
                      size_t count) const;
  void CaptureAll() const;
  void DrawAll(float extent) const;

  Spec spec_;
  size_t patches_;
  Programs programs_;
  GlBuffer nets_;
  GlTarget target_;
  GLuint vertex_array_ = 0;
  size_t triangles_ = 0;
  size_t batch_ = 0;
  GlBuffer captured_, probed_;
};

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_PAPER_SHADERS_SHADER_TESSELLATOR_H_
