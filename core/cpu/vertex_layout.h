// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Where the vertices of a view lie, and how one is written: the wire layout of core/backend.h.
//
//   chunk c begins at byte  ChunkPatches(c)[0] * PointsPerPatch * BytesPerPoint
//   kFloat32    point i at 24 i (12 i without normals): float x y z [nx ny nz]
//   kQuantised  with N = points of the chunk: uint16 x[N] y[N] z[N], then s[N] t[N] in 1 or 2 bytes
//
//   integer = clamp(round((p - (box.origin - local_origin)) / step), 0, 2^bits - 1),  p relative to
//   the plan's local origin, in double: one multiplication and one addition an axis
//
// Threads  pure; distinct points may be written at once
#ifndef LATTICED_CORE_CPU_VERTEX_LAYOUT_H_
#define LATTICED_CORE_CPU_VERTEX_LAYOUT_H_

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "core/backend.h"
#include "core/base/limits.h"
#include "core/codec/octahedral.h"
#include "core/ffd/tessellation_pattern.h"

namespace latticed {

class VertexLayout {
 public:
  VertexLayout(const DeformPlan& plan, const ViewSpec& spec)
      : plan_(plan),
        spec_(spec),
        points_per_patch_(static_cast<size_t>(PointsPerPatch(spec.segments))),
        bytes_per_point_(BytesPerPoint(spec)) {}

  size_t points_per_patch() const { return points_per_patch_; }
  size_t total_bytes() const { return plan_.patches.size() * points_per_patch_ * bytes_per_point_; }
  size_t ChunkOffset(size_t chunk) const {
    return plan_.ChunkPatches(chunk)[0] * points_per_patch_ * bytes_per_point_;
  }
  size_t ChunkBytes(size_t chunk) const {
    return ChunkPoints(plan_, chunk, spec_.segments) * bytes_per_point_;
  }

  // The points of one patch inside the bytes of its chunk.
  struct PatchPlace {
    uint8_t* chunk = nullptr;  // first byte of the chunk
    size_t chunk_points = 0;
    size_t first_point = 0;  // of the patch, in the chunk
  };
  PatchPlace Place(std::span<uint8_t> vertices, size_t patch) const {
    const size_t chunk = patch / static_cast<size_t>(limits::kPatchesPerChunk);
    const size_t first = plan_.ChunkPatches(chunk)[0];
    return {vertices.data() + ChunkOffset(chunk), ChunkPoints(plan_, chunk, spec_.segments),
            (patch - first) * points_per_patch_};
  }

  // Position of one point copied from another place, bit for bit; its normal stays.
  void CopyPosition(const PatchPlace& from, size_t from_point, const PatchPlace& to,
                    size_t to_point) const {
    const size_t a = from.first_point + from_point, b = to.first_point + to_point;
    if (spec_.format == VertexFormat::kFloat32) {
      std::memcpy(to.chunk + b * bytes_per_point_, from.chunk + a * bytes_per_point_,
                  3 * sizeof(float));
      return;
    }
    for (size_t axis = 0; axis < 3; ++axis) {
      std::memcpy(to.chunk + (axis * to.chunk_points + b) * sizeof(uint16_t),
                  from.chunk + (axis * from.chunk_points + a) * sizeof(uint16_t), sizeof(uint16_t));
    }
  }

 private:
  const DeformPlan& plan_;
  ViewSpec spec_;
  size_t points_per_patch_;
  size_t bytes_per_point_;
};

// Writes positions and normals of single points in a view's format under one quantisation box.
class VertexWriter {
 public:
  VertexWriter(const DeformPlan& plan, const ViewSpec& spec, const QuantisationBox& box)
      : spec_(spec), bytes_per_point_(BytesPerPoint(spec)) {
    const double step = box.step(spec.position_bits);
    scale_ = 1.0 / step;
    const Vec3d origin = box.origin - plan.local_origin;
    offset_ = (-scale_) * origin;
    largest_ = static_cast<double>((uint32_t{1} << spec.position_bits) - 1);
  }

  void WritePosition(const VertexLayout::PatchPlace& place, size_t point, Vec3d p) const {
    const size_t i = place.first_point + point;
    if (spec_.format == VertexFormat::kFloat32) {
      const Vec3f rounded = ToFloat(p);
      std::memcpy(place.chunk + i * bytes_per_point_, &rounded, sizeof(rounded));
      return;
    }
    for (int axis = 0; axis < 3; ++axis) {
      const uint16_t q = Quantise(p[axis] * scale_ + offset_[axis]);
      std::memcpy(place.chunk + (static_cast<size_t>(axis) * place.chunk_points + i) * sizeof(q),
                  &q, sizeof(q));
    }
  }

  void WriteNormal(const VertexLayout::PatchPlace& place, size_t point, Vec3f n) const {
    const size_t i = place.first_point + point;
    if (spec_.format == VertexFormat::kFloat32) {
      std::memcpy(place.chunk + i * bytes_per_point_ + sizeof(Vec3f), &n, sizeof(n));
      return;
    }
    const OctahedralNormal o = QuantiseNormal(n, spec_.normal_bits);
    uint8_t* normals = place.chunk + 3 * sizeof(uint16_t) * place.chunk_points;
    if (spec_.normal_bits <= 8) {
      normals[i] = static_cast<uint8_t>(o.s);
      normals[place.chunk_points + i] = static_cast<uint8_t>(o.t);
      return;
    }
    const uint16_t s = static_cast<uint16_t>(o.s), t = static_cast<uint16_t>(o.t);
    std::memcpy(normals + i * sizeof(s), &s, sizeof(s));
    std::memcpy(normals + (place.chunk_points + i) * sizeof(t), &t, sizeof(t));
  }

 private:
  // Comparisons first: a NaN becomes 0, and the cast stays defined.
  uint16_t Quantise(double x) const {
    const double shifted = x + 0.5;
    if (!(shifted > 0)) return 0;
    return static_cast<uint16_t>(shifted < largest_ ? shifted : largest_);
  }

  ViewSpec spec_;
  size_t bytes_per_point_;
  double scale_ = 1, largest_ = 0;
  Vec3d offset_;
};

}  // namespace latticed

#endif  // LATTICED_CORE_CPU_VERTEX_LAYOUT_H_
