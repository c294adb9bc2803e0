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

struct FusedVertex {
  float3 position;
  float3 normal;  // any length
  float norm1;    // |normal|_1
};

// The vertices of one lane. Places are bytes from the lane's first vertex.
class VertexSink {
 public:
  __device__ VertexSink(const FusedLaunch& launch, uint32_t chunk, unsigned lane)
      : out_(launch.output),
        stride_(out_.format == LaneFormat::kFloat32
                    ? (launch.normals == Normals::kNone ? 3 : 6) * kRowBytes
                    : 2 * kRowBytes),
        lane_(lane * (out_.format == LaneFormat::kFloat32 ? sizeof(float) : sizeof(uint2))),
        centre_(static_cast<float>((1 << (out_.normal_bits - 1)) - 1)) {
    const int points = (launch.segments + 1) * (launch.segments + 2) / 2;
    const size_t first = size_t{chunk} * static_cast<unsigned>(points);
    base_ = out_.vertices + first * stride_;
    second_ = out_.second_plane + first * kRowBytes;
  }

  // Bytes from a point to the next.
  __device__ unsigned stride() const { return stride_; }
  __device__ unsigned Place(int point) const {
    return lane_ + static_cast<unsigned>(point) * stride_;
  }

  // Positions alone.
  __device__ __forceinline__ void Store(unsigned place, float3 p) const {
    if (out_.format == LaneFormat::kFloat32) return StoreFloats(place, p);
    const uint3 q = Quantise(p);
    StoreWords(place, __byte_perm(q.x, q.y, 0x5410), q.z & 0xffff);
  }

  // `scale` keeps the square of the normal from underflow.
  __device__ __forceinline__ void Store(unsigned place, const FusedVertex& v, float scale) const {
    if (out_.format == LaneFormat::kFloat32) {
      StoreFloats(place, v.position);
      const float3 n{v.normal.x * scale, v.normal.y * scale, v.normal.z * scale};
      const float inverse = rsqrtf(fmaf(n.x, n.x, fmaf(n.y, n.y, n.z * n.z)));
      return StoreFloats(place + 3 * kRowBytes, {n.x * inverse, n.y * inverse, n.z * inverse});
    }
    const uint3 q = Quantise(v.position);
    const uint2 st = QuantiseDirection(v.normal, v.norm1, centre_);
    const uint32_t xy = __byte_perm(q.x, q.y, 0x5410);
    if (out_.format == LaneFormat::kQuantised8) {
      return StoreWords(place, xy, __byte_perm(__byte_perm(q.z, st.x, 0x0410), st.y, 0x4210));
    }
    StoreWords(place, xy, q.z & 0xffff);
    SecondWord(place) = __byte_perm(st.x, st.y, 0x5410);
  }

  // Replaces the normal of a stored vertex.
  __device__ void StoreNormal(unsigned place, Vec3f n) const {
    if (out_.format == LaneFormat::kFloat32) {
      return StoreFloats(place + 3 * kRowBytes, {n.x, n.y, n.z});
    }
    const OctahedralNormal o = QuantiseNormal(n, out_.normal_bits);
    if (out_.format == LaneFormat::kQuantised8) {
      base_[place + 6] = static_cast<uint8_t>(o.s);
      base_[place + 7] = static_cast<uint8_t>(o.t);
      return;
    }
    SecondWord(place) = static_cast<uint32_t>(o.s) | static_cast<uint32_t>(o.t) << 16;
  }

 private:
  static constexpr unsigned kRowBytes = 32 * sizeof(float);

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
  // Half as wide as the words, so at half the place.
  __device__ __forceinline__ uint32_t& SecondWord(unsigned place) const {
    return *reinterpret_cast<uint32_t*>(second_ + place / 2);
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
  const unsigned stride_, lane_;
  const float centre_;
  uint8_t* base_;    // of the chunk
  uint8_t* second_;
};

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_FUSED_STORE_CUH_
