// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How a lane writes its vertices, in the lane order of fused_kernels.h.
#ifndef LATTICED_CUDA_FUSED_STORE_CUH_
#define LATTICED_CUDA_FUSED_STORE_CUH_

#include "core/codec/octahedral.h"
#include "cuda/fused_kernels.h"

namespace latticed::kernels {

// Added to a float of magnitude below 2^22, rounds it to an integer, which stands in the low bits.
constexpr float kRound = 12582912.0f;  // 1.5 * 2^23

// Octahedral coordinates of a direction, as core/codec/octahedral.h but for ties: in the low 16 bits
// of each. `norm1` is |n|_1, `centre` 2^(bits - 1) - 1.
__device__ __forceinline__ uint2 QuantiseDirection(float3 n, float norm1, float centre) {
  const float scale = __fdividef(centre, norm1);
  const float x = fmaf(n.x, scale, kRound) - kRound, y = fmaf(n.y, scale, kRound) - kRound;
  // Integers of L1 norm `centre`; what rounding x and y up overshot goes from y, z takes the rest.
  const float rest = centre - fabsf(x), y_size = fminf(fabsf(y), rest), z_size = rest - y_size;
  if (x >= 0) {
    return {__float_as_uint(copysignf(y_size, n.y) + (centre + kRound)),
            __float_as_uint(copysignf(z_size, n.z) + (centre + kRound))};
  }
  const float s = copysignf(centre - z_size, n.y) + centre,
              t = copysignf(centre - y_size, n.z) + centre;
  if (fminf(y_size, z_size) > 0) {
    return {__float_as_uint(s + kRound), __float_as_uint(t + kRound)};
  }
  // The rim of the square names directions twice.
  const int bits = 33 - __clz(static_cast<int>(centre));
  const OctahedralNormal rim =
      CanonicaliseOctahedral({static_cast<int32_t>(s), static_cast<int32_t>(t)}, bits);
  return {static_cast<uint32_t>(rim.s), static_cast<uint32_t>(rim.t)};
}

// The vertices of one lane.
class VertexSink {
 public:
  __device__ VertexSink(const FusedLaunch& launch, uint32_t chunk, unsigned lane)
      : out_(launch.output), centre_((1 << (out_.normal_bits - 1)) - 1) {
    const bool floats = out_.format == LaneFormat::kFloat32;
    const unsigned numbers = launch.normals == Normals::kNone ? 3 : 6;
    stride_ = kLanes * (floats ? numbers * sizeof(float) : sizeof(uint2));
    const int points = (launch.segments + 1) * (launch.segments + 2) / 2;
    const size_t first = size_t{chunk} * static_cast<unsigned>(points);
    base_ = out_.vertices + first * stride_ + lane * (floats ? sizeof(float) : sizeof(uint2));
    second_ = out_.second_plane + (first * kLanes + lane) * sizeof(uint32_t);
  }

  __device__ __forceinline__ void Store(int point, float3 p) const {
    if (out_.format == LaneFormat::kFloat32) return StoreFloats(point, 0, p);
    const uint3 q = Quantise(p);
    StoreWords(point, {__byte_perm(q.x, q.y, 0x5410), q.z & 0xffff});
  }

  // `n` has the normal's direction, `norm1` = |n|_1; `scale` keeps its square from underflow.
  __device__ __forceinline__ void Store(int point, float3 p, float3 n, float norm1,
                                        float scale) const {
    if (out_.format == LaneFormat::kFloat32) {
      StoreFloats(point, 0, p);
      n = {n.x * scale, n.y * scale, n.z * scale};
      const float inverse = rsqrtf(fmaf(n.x, n.x, fmaf(n.y, n.y, n.z * n.z)));
      return StoreFloats(point, 3, {n.x * inverse, n.y * inverse, n.z * inverse});
    }
    const uint3 q = Quantise(p);
    const uint2 st = QuantiseDirection(n, norm1, static_cast<float>(centre_));
    const uint32_t xy = __byte_perm(q.x, q.y, 0x5410);
    if (out_.format == LaneFormat::kQuantised8) {
      const uint32_t zs = __byte_perm(q.z, st.x, 0x0410);
      return StoreWords(point, {xy, __byte_perm(zs, st.y, 0x4210)});
    }
    StoreWords(point, {xy, q.z & 0xffff});
    SecondWord(point, 0) = __byte_perm(st.x, st.y, 0x5410);
  }

  // Replaces the normal of a stored vertex, `lanes` further than this one.
  __device__ void StoreNormal(int point, int lanes, Vec3f n) const {
    if (out_.format == LaneFormat::kFloat32) {
      float* row = reinterpret_cast<float*>(Place(point)) + 3 * kLanes + lanes;
      row[0] = n.x;
      row[kLanes] = n.y;
      row[2 * kLanes] = n.z;
      return;
    }
    const OctahedralNormal o = QuantiseNormal(n, out_.normal_bits);
    if (out_.format == LaneFormat::kQuantised8) {
      uint8_t* word = reinterpret_cast<uint8_t*>(reinterpret_cast<uint2*>(Place(point)) + lanes);
      word[6] = static_cast<uint8_t>(o.s);
      word[7] = static_cast<uint8_t>(o.t);
      return;
    }
    SecondWord(point, lanes) = static_cast<uint32_t>(o.s) | static_cast<uint32_t>(o.t) << 16;
  }

 private:
  static constexpr unsigned kLanes = 32;

  __device__ __forceinline__ uint8_t* Place(int point) const {
    return base_ + static_cast<unsigned>(point) * stride_;
  }
  __device__ __forceinline__ void StoreFloats(int point, unsigned first, float3 v) const {
    float* row = reinterpret_cast<float*>(Place(point)) + first * kLanes;
    row[0] = v.x;
    row[kLanes] = v.y;
    row[2 * kLanes] = v.z;
  }
  __device__ __forceinline__ void StoreWords(int point, uint2 words) const {
    *reinterpret_cast<uint2*>(Place(point)) = words;
  }
  __device__ __forceinline__ uint32_t& SecondWord(int point, int lanes) const {
    return reinterpret_cast<uint32_t*>(second_)[point * static_cast<int>(kLanes) + lanes];
  }

  // In the low 16 bits; saturation also makes 0 of NaN.
  __device__ __forceinline__ uint32_t QuantiseAxis(float p, float offset) const {
    return __float_as_uint(fmaf(__saturatef(fmaf(p, out_.scale, offset)), out_.top, kRound));
  }
  __device__ __forceinline__ uint3 Quantise(float3 p) const {
    return {QuantiseAxis(p.x, out_.offset[0]), QuantiseAxis(p.y, out_.offset[1]),
            QuantiseAxis(p.z, out_.offset[2])};
  }

  const FusedOutput& out_;
  int centre_;
  unsigned stride_;  // bytes from point to point
  uint8_t* base_;
  uint8_t* second_;
};

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_FUSED_STORE_CUH_
