// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A patch in 16 bytes: its box, its vertices, and the boxes that own the points of its corners and edges.
//
//   word c = 0..2   bits 0..27 vertex of corner c | 28..30 steps of edge c | 31 edge c is on a seam
//   word 3          bits 0..19 box | 20..28 steps of corners 0, 1, 2 | 29..31 corner c is on a seam
//
// Bit a of the steps says that the owner is the next lower box along axis a: the corner or edge lies in the
// knot plane between the two boxes. A table of SeamUse says on which seam a corner or edge is.
//                                                                          core/ffd/plan/deform_plan.h
// Threads  plain data, host and device
#ifndef LATTICED_CUDA_PLAN_DEVICE_PATCH_H_
#define LATTICED_CUDA_PLAN_DEVICE_PATCH_H_

#include <cstdint>

#include "core/base/host_device.h"

namespace latticed::kernels {

inline constexpr uint32_t kDeviceVertices = uint32_t{1} << 28;
inline constexpr uint32_t kDeviceBoxes = uint32_t{1} << 20;

struct alignas(16) DevicePatch {
  uint32_t word[4];

  LATTICED_HD uint32_t Box() const { return word[3] & (kDeviceBoxes - 1); }
  LATTICED_HD uint32_t Vertex(int corner) const { return word[corner] & (kDeviceVertices - 1); }
  LATTICED_HD uint32_t EdgeSteps(int edge) const { return word[edge] >> 28 & 7; }
  LATTICED_HD bool EdgeOnSeam(int edge) const { return word[edge] >> 31 != 0; }
  LATTICED_HD uint32_t CornerSteps(int corner) const { return word[3] >> (20 + 3 * corner) & 7; }
  LATTICED_HD bool CornerOnSeam(int corner) const { return (word[3] >> (29 + corner) & 1) != 0; }
};

// slot 0..2 is a corner, 3..5 an edge. The table is in ascending order of key.
struct SeamUse {
  uint32_t key;  // patch * 8 + slot
  uint32_t seam;
};

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_PLAN_DEVICE_PATCH_H_
