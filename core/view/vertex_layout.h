// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Where the vertices of a view lie, and how one is written: the wire layout of core/backend.h, for
// both compilers. core/view/view_layout.h makes these of a plan and a view's spec.
//
//   chunk c begins at byte  32 c * points_per_patch * bytes_per_point
//   kFloat32    point i at 24 i (12 i without normals): float x y z [nx ny nz]
//   kQuantised  with N = points of the chunk: uint16 x[N] y[N] z[N], then s[N] t[N] in 1 or 2 bytes
//
//   integer = clamp(round((p - (box.origin - local_origin)) / step), 0, 2^bits - 1),  p relative to
//   the plan's local origin, in double: one multiplication and one addition per axis
//
// Vertices begin at a multiple of 4 bytes; then every number lies at a multiple of its own size.
// Threads  pure; distinct points may be written at once. Host and device, plain data
#ifndef LATTICED_CORE_VIEW_VERTEX_LAYOUT_H_
#define LATTICED_CORE_VIEW_VERTEX_LAYOUT_H_

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "core/base/host_device.h"
#include "core/base/limits.h"
#include "core/base/vec.h"
#include "core/codec/octahedral.h"

namespace latticed {

// The numbers of a view's spec and plan on which its bytes depend.
struct VertexShape {
  size_t patches = 0;
  size_t points_per_patch = 0;
  size_t bytes_per_point = 0;
  bool quantised = false;
  int normal_bits = 0;  // kQuantised with normals only
};

// Stores a number in a buffer of bytes. It is aligned, which a compiler cannot know from a byte pointer.
template <typename T>
LATTICED_HD inline void StoreNumber(uint8_t* to, T value) {
  std::memcpy(__builtin_assume_aligned(to, alignof(T)), &value, sizeof(T));
}
template <typename T>
LATTICED_HD inline void CopyNumber(uint8_t* to, const uint8_t* from) {
  T value;
  std::memcpy(&value, __builtin_assume_aligned(from, alignof(T)), sizeof(T));
  StoreNumber(to, value);
}

// The points of one patch inside the bytes of its chunk.
struct PatchPlace {
  uint8_t* chunk = nullptr;  // first byte of the chunk
  size_t chunk_points = 0;
  size_t first_point = 0;  // of the patch, in the chunk
};

class VertexLayout {
 public:
  VertexLayout() = default;
  explicit VertexLayout(const VertexShape& shape) : shape_(shape) {}

  LATTICED_HD size_t points_per_patch() const { return shape_.points_per_patch; }
  size_t total_bytes() const { return Bytes(shape_.patches); }
  LATTICED_HD size_t ChunkOffset(size_t chunk) const { return Bytes(chunk * kPatches); }
  size_t ChunkBytes(size_t chunk) const { return ChunkPoints(chunk) * shape_.bytes_per_point; }

  LATTICED_HD PatchPlace Place(uint8_t* vertices, size_t patch) const {
    const size_t chunk = patch / kPatches;
    return {vertices + ChunkOffset(chunk), ChunkPoints(chunk),
            patch % kPatches * shape_.points_per_patch};
  }

  // Copies the position of one point from another place, bit for bit. The normal stays.
  LATTICED_HD void CopyPosition(const PatchPlace& from, size_t from_point, const PatchPlace& to,
                                size_t to_point) const {
    const size_t a = from.first_point + from_point, b = to.first_point + to_point;
    for (size_t axis = 0; axis < 3; ++axis) {
      if (shape_.quantised) {
        CopyNumber<uint16_t>(to.chunk + (axis * to.chunk_points + b) * sizeof(uint16_t),
                             from.chunk + (axis * from.chunk_points + a) * sizeof(uint16_t));
      } else {
        CopyNumber<float>(to.chunk + b * shape_.bytes_per_point + axis * sizeof(float),
                          from.chunk + a * shape_.bytes_per_point + axis * sizeof(float));
      }
    }
  }

 private:
  static constexpr size_t kPatches = limits::kPatchesPerChunk;

  LATTICED_HD size_t Bytes(size_t patches) const {
    return patches * shape_.points_per_patch * shape_.bytes_per_point;
  }
  LATTICED_HD size_t ChunkPoints(size_t chunk) const {
    const size_t first = chunk * kPatches, left = shape_.patches - first;
    return (left < kPatches ? left : kPatches) * shape_.points_per_patch;
  }

  VertexShape shape_;
};

// Writes positions and normals of single points in a view's format under one quantisation box.
class VertexWriter {
 public:
  VertexWriter() = default;
  // scale and offset: integer = round(scale p + offset), up to `largest`.
  VertexWriter(const VertexShape& shape, double scale, Vec3d offset, double largest)
      : shape_(shape), scale_(scale), offset_(offset), largest_(largest) {}

  LATTICED_HD void WritePosition(const PatchPlace& place, size_t point, Vec3d p) const {
    const size_t i = place.first_point + point;
    if (!shape_.quantised) {
      StoreVector(place.chunk + i * shape_.bytes_per_point, ToFloat(p));
      return;
    }
    for (int axis = 0; axis < 3; ++axis) {
      StoreNumber(
          place.chunk + (static_cast<size_t>(axis) * place.chunk_points + i) * sizeof(uint16_t),
          Quantise(p[axis] * scale_ + offset_[axis]));
    }
  }

  LATTICED_HD void WriteNormal(const PatchPlace& place, size_t point, Vec3f n) const {
    const size_t i = place.first_point + point;
    if (!shape_.quantised) {
      StoreVector(place.chunk + i * shape_.bytes_per_point + sizeof(Vec3f), n);
      return;
    }
    const OctahedralNormal o = QuantiseNormal(n, shape_.normal_bits);
    uint8_t* normals = place.chunk + 3 * sizeof(uint16_t) * place.chunk_points;
    if (shape_.normal_bits <= 8) {
      normals[i] = static_cast<uint8_t>(o.s);
      normals[place.chunk_points + i] = static_cast<uint8_t>(o.t);
      return;
    }
    StoreNumber(normals + i * sizeof(uint16_t), static_cast<uint16_t>(o.s));
    StoreNumber(normals + (place.chunk_points + i) * sizeof(uint16_t), static_cast<uint16_t>(o.t));
  }

 private:
  LATTICED_HD static void StoreVector(uint8_t* to, Vec3f v) {
    StoreNumber(to, v.x);
    StoreNumber(to + sizeof(float), v.y);
    StoreNumber(to + 2 * sizeof(float), v.z);
  }
  // Comparisons first: a NaN becomes 0, and the cast stays defined.
  LATTICED_HD uint16_t Quantise(double x) const {
    const double shifted = x + 0.5;
    if (!(shifted > 0)) return 0;
    return static_cast<uint16_t>(shifted < largest_ ? shifted : largest_);
  }

  VertexShape shape_;
  double scale_ = 1;
  Vec3d offset_;
  double largest_ = 0;
};

}  // namespace latticed

#endif  // LATTICED_CORE_VIEW_VERTEX_LAYOUT_H_
