// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/codec/draco_container.h"

#include "core/codec/octahedral.h"

namespace latticed {
namespace {

using draco_format::kCanonicalOctahedron;
using draco_format::kCloud;
using draco_format::kCloudMinor;
using draco_format::kDifference;
using draco_format::kFloat32;
using draco_format::kMajor;
using draco_format::kMesh;
using draco_format::kMeshMinor;
using draco_format::kNormalType;
using draco_format::kOctahedralCoder;
using draco_format::kPositionType;
using draco_format::kQuantisedCoder;
using draco_format::kSequential;
using draco_format::kWrap;

void WriteHeader(uint32_t minor, uint32_t geometry, ByteWriter& out) {
  constexpr uint8_t kMagic[] = {'D', 'R', 'A', 'C', 'O'};
  out.Bytes(kMagic);
  for (const uint32_t byte : {kMajor, minor, geometry, kSequential}) out.Byte(byte);
  out.Plain(uint16_t{0});  // no metadata
}

void WriteDescriptors(int normal_bits, ByteWriter& out) {
  const uint32_t attributes = normal_bits > 0 ? 2 : 1;
  out.Byte(1);
  out.Byte(attributes);
  for (uint32_t id = 0; id < attributes; ++id) {
    const uint32_t type = id == 0 ? kPositionType : kNormalType;
    for (const uint32_t byte : {type, kFloat32, 3u, 0u, id}) out.Byte(byte);
  }
  out.Byte(kQuantisedCoder);
  if (normal_bits > 0) out.Byte(kOctahedralCoder);
}

}  // namespace

void WriteCloudHead(size_t point_count, int normal_bits, ByteWriter& out) {
  WriteHeader(kCloudMinor, kCloud, out);
  out.Plain(static_cast<int32_t>(point_count));
  WriteDescriptors(normal_bits, out);
}

void WriteMeshHead(std::span<const uint8_t> connectivity, int normal_bits, ByteWriter& out) {
  WriteHeader(kMeshMinor, kMesh, out);
  out.Bytes(connectivity);
  WriteDescriptors(normal_bits, out);
}

void WritePrediction(DracoAttribute attribute, ByteWriter& out) {
  out.Byte(kDifference);
  out.Byte(attribute == DracoAttribute::kPosition ? kWrap : kCanonicalOctahedron);
}

void WritePositionBounds(uint32_t least, uint32_t most, ByteWriter& out) {
  out.Plain(static_cast<int32_t>(least));
  out.Plain(static_cast<int32_t>(most));
}

void WriteNormalBounds(int normal_bits, ByteWriter& out) {
  out.Plain(OctahedralMax(normal_bits) + 1);  // the modulus
  out.Plain(OctahedralMax(normal_bits) / 2);  // the centre
}

void WriteDequantisation(int position_bits, int normal_bits, float range, ByteWriter& out) {
  for (int axis = 0; axis < 3; ++axis) out.Plain(0.0f);
  out.Plain(range);
  out.Byte(static_cast<uint32_t>(position_bits));
  if (normal_bits > 0) out.Byte(static_cast<uint32_t>(normal_bits));
}

}  // namespace latticed
