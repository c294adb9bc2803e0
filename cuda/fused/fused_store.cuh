// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How a lane converts its vertices to the output format and writes them in the lane order of
// fused_kernels.h.
#ifndef LATTICED_CUDA_FUSED_FUSED_STORE_CUH_
#define LATTICED_CUDA_FUSED_FUSED_STORE_CUH_

#include <type_traits>

#include "core/codec/octahedral.h"
#include "cuda/fused/fused_kernels.h"

namespace latticed::kernels {

// Adding it to a float of magnitude below 2^22 rounds that to an integer, which is then the low bits.
constexpr float kRound = 12582912.0f;  // 1.5 * 2^23

// Faster than a division, which treats denormal numbers correctly.
__device__ __forceinline__ float ApproximateReciprocal(float x) {
  float result;
  asm("rcp.approx.ftz.f32 %0, %1;" : "=f"(result) : "f"(x));
  return result;
}

// Octahedral coordinates (s, t) of a direction, each in the low 16 bits; `centre` = 2^(bits - 1) - 1.
//
//   s = centre + sign(y) (|y| + max(-x, 0)) centre / |n|_1,   t likewise with z
//
// This is the map of core/codec/octahedral.h without a branch, rounded to nearest on each axis. On the rim
// of the square a direction has two pairs of coordinates, and the sign of a y or z that is zero decides.
// Rounding errors would choose that sign at random. So the direction is first moved by kBias, a fraction
// of the finest step: the numbers of a flat or ruled surface then stay smooth and compress well.
constexpr float kBias = 0x1p-16f;
__device__ __forceinline__ uint2 QuantiseDirection(float3 n, float norm1, float centre) {
  const float scale = centre * ApproximateReciprocal(norm1), back = fmaxf(-n.x, 0.0f);
  const float y = fmaf(norm1, kBias, n.y), z = fmaf(norm1, kBias, n.z);
  return {__float_as_uint(fmaf(copysignf(fabsf(y) + back, y), scale, centre + kRound)),
          __float_as_uint(fmaf(copysignf(fabsf(z) + back, z), scale, centre + kRound))};
}

// Writes the vertices of one lane. A place is a number of bytes from the chunk's first vertex.
template <bool kFloat>
class VertexSink {
 public:
  // A position as it is stored; quantised, x | y << 16 and z.
  using Position = std::conditional_t<kFloat, float3, uint2>;
  static constexpr int kPositionWords = sizeof(Position) / sizeof(float);
  // A vertex before it is stored; a quantised normal is s and t, each in the low 16 bits.
  struct Vertex {
    Position position;
    std::conditional_t<kFloat, float3, uint2> normal;
  };

  __device__ VertexSink(const FusedLaunch& launch, uint32_t chunk, unsigned lane)
      : normals_(launch.normals != Normals::kNone),
        normal_bits_(launch.output.normal_bits),
        wide_(launch.output.format == LaneFormat::kQuantised16),
        stride_(kRowBytes * (kFloat && launch.normals != Normals::kNone ? 6
                             : kFloat                                   ? 3
                                                                        : 2)),
        lane_(lane * (kFloat ? sizeof(float) : sizeof(uint2))),
        top_(launch.output.top),
        centre_(static_cast<float>((1 << (normal_bits_ - 1)) - 1)) {
    const int points = (launch.segments + 1) * (launch.segments + 2) / 2;
    const size_t first = size_t{chunk} * static_cast<unsigned>(points);
    base_ = launch.output.vertices + first * stride_;
    second_ = launch.output.second_plane + first * kRowBytes;
  }

  // Bytes from one point to the next.
  __device__ unsigned stride() const { return stride_; }
  __device__ unsigned Place(int point) const {
    return lane_ + static_cast<unsigned>(point) * stride_;
  }

  // For quantised formats `p` is 0 to 1 over the quantisation box. NaN becomes 0.
  __device__ __forceinline__ Position MakePosition(float3 p) const {
    if constexpr (kFloat) {
      return p;
    } else {
      const auto quantise = [this](float x) {
        return __float_as_uint(fmaf(__saturatef(x), top_, kRound));
      };
      return {__byte_perm(quantise(p.x), quantise(p.y), 0x5410), quantise(p.z)};
    }
  }

  // `n` has the normal's direction, `norm1` = |n|_1; `scale` keeps its square in float's range.
  __device__ __forceinline__ Vertex MakeVertex(Position p, float3 n, float norm1,
                                               float scale) const {
    if constexpr (kFloat) {
      n = {n.x * scale, n.y * scale, n.z * scale};
      const float inverse = rsqrtf(fmaf(n.x, n.x, fmaf(n.y, n.y, n.z * n.z)));
      return {p, {n.x * inverse, n.y * inverse, n.z * inverse}};
    } else {
      return {p, QuantiseDirection(n, norm1, centre_)};
    }
  }

  // Stores all vertices with one branch, so that their instructions can overlap. Views without normals need
  // none: s and t in their quantised words mean nothing.
  template <unsigned kCount>
  __device__ __forceinline__ void Store(const unsigned (&places)[kCount],
                                        const Vertex (&vertices)[kCount]) const {
#pragma unroll
    for (unsigned i = 0; i < kCount; ++i) StorePosition(places[i], vertices[i]);
    if (kFloat ? !normals_ : !wide_) return;
#pragma unroll
    for (unsigned i = 0; i < kCount; ++i) StoreRest(places[i], vertices[i].normal);
  }

  // Replaces the normal of a stored vertex.
  __device__ void StoreNormal(unsigned place, Vec3f n) const {
    if constexpr (kFloat) {
      StoreFloats(place + 3 * kRowBytes, {n.x, n.y, n.z});
    } else {
      const OctahedralNormal o = QuantiseNormal(n, normal_bits_);
      if (wide_) {
        SecondWord(place) = static_cast<uint32_t>(o.s) | static_cast<uint32_t>(o.t) << 16;
      } else {
        base_[place + 6] = static_cast<uint8_t>(o.s);
        base_[place + 7] = static_cast<uint8_t>(o.t);
      }
    }
  }

 private:
  static constexpr unsigned kRowBytes = 32 * sizeof(float);

  __device__ __forceinline__ void StorePosition(unsigned place, const Vertex& v) const {
    if constexpr (kFloat) {
      StoreFloats(place, v.position);
    } else {
      // With wide normals, s and t are written here too, and nothing reads them.
      const uint32_t zs = __byte_perm(v.position.y, v.normal.x, 0x0410);
      StoreWords(place, v.position.x, __byte_perm(zs, v.normal.y, 0x4210));
    }
  }
  __device__ __forceinline__ void StoreRest(unsigned place, float3 n) const {
    StoreFloats(place + 3 * kRowBytes, n);
  }
  __device__ __forceinline__ void StoreRest(unsigned place, uint2 st) const {
    SecondWord(place) = __byte_perm(st.x, st.y, 0x5410);
  }
  __device__ __forceinline__ void StoreFloats(unsigned place, float3 v) const {
    auto* row = reinterpret_cast<float*>(base_ + place);
    row[0] = v.x;
    row[32] = v.y;
    row[64] = v.z;
  }
  __device__ __forceinline__ void StoreWords(unsigned place, uint32_t first,
                                             uint32_t second) const {
    *reinterpret_cast<uint2*>(base_ + place) = {first, second};
  }
  // The second plane has 4 bytes where the first has 8.
  __device__ __forceinline__ uint32_t& SecondWord(unsigned place) const {
    return *reinterpret_cast<uint32_t*>(second_ + place / 2);
  }

  const bool normals_;
  const int normal_bits_;
  const bool wide_;
  const unsigned stride_, lane_;
  const float top_, centre_;
  uint8_t* base_;  // of the chunk
  uint8_t* second_;
};

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_FUSED_FUSED_STORE_CUH_
