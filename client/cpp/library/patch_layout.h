// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Points and triangles of one patch: Topology.pattern, or with a tolerance the PatchPattern that Chunk.levels names.
//
// Threads  immutable; refers to the Surface that it came from
#ifndef LATTICED_CLIENT_CPP_LIBRARY_PATCH_LAYOUT_H_
#define LATTICED_CLIENT_CPP_LIBRARY_PATCH_LAYOUT_H_

#include <cstddef>
#include <cstdint>
#include <span>

namespace latticed::client {

struct PatchLayout {
  double denominator = 1;
  std::span<const uint32_t> points;  // three integers a point: barycentrics times denominator
  std::span<const uint32_t>
      triangles;  // three a triangle: points of the patch, each below point_count()

  size_t point_count() const { return points.size() / 3; }
  size_t triangle_count() const { return triangles.size() / 3; }
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LIBRARY_PATCH_LAYOUT_H_
