// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// One vertex of a triangle from the tessellator.
//
// Units    position is relative to the plan's local origin
#ifndef LATTICED_TESTS_BENCH_PAPER_SHADERS_SHADER_VERTEX_H_
#define LATTICED_TESTS_BENCH_PAPER_SHADERS_SHADER_VERTEX_H_

#include <cstdint>

#include "core/base/vec.h"

namespace latticed::bench {

struct ShaderVertex {
  Vec3f position, normal;
  Vec3f coordinate;  // gl_TessCoord: barycentrics in float32
  int32_t patch = 0;
};

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_PAPER_SHADERS_SHADER_VERTEX_H_
