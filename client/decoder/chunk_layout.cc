// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/decoder/chunk_layout.h"

#include <algorithm>
#include <cstring>

#include "client/decoder/symbol_stream.h"
#include "core/codec/draco_container.h"
#include "core/codec/rans_model.h"

namespace latticed::decoder {
namespace {

using draco_format::kCloud;
using draco_format::kCloudMinor;
using draco_format::kCompressedIndices;
using draco_format::kFloat32;
using draco_format::kMajor;
using draco_format::kMesh;
using draco_format::kMeshMinor;
using draco_format::kNormalType;
using draco_format::kOctahedralCoder;
using draco_format::kPositionType;
using draco_format::kQuantisedCoder;
using draco_format::kSequential;

template <size_t kCount>
bool Is(ByteReader& in, const uint32_t (&expected)[kCount]) {
  for (const uint32_t byte : expected) {
    if (in.Byte() != byte) return false;
  }
  return in.ok();
}

bool IsAttribute(ByteReader& in, uint32_t type, uint32_t id) {
  return Is(in, {type, kFloat32, 3u, 0u, id});
}

// Reads the triangles, and forgets them: the tessellation's pattern has them too.
bool ReadConnectivity(ByteReader& in, uint32_t points, WideTable* table, uint32_t* faces) {
  *faces = in.Varint();
  if (in.Varint() != points || in.Byte() != kCompressedIndices || !in.ok()) return false;
  if (*faces == 0) return true;
  if (*faces > 4 * uint64_t{points} || in.Byte() != kSchemeRaw) return false;
  const CodedSymbols coded = ReadRawCoded(in, 2 * points, nullptr, table);
  if (coded.kind != TableKind::kWide) return false;
  uint32_t last = 0;
  return DecodeWideStates(coded.begin, coded.end, 3 * *faces, *table, [&](uint32_t symbol) {
    const uint32_t distance = symbol >> 1;
    if ((symbol & 1) != 0 ? distance > last : distance >= points - last) return false;
    last = (symbol & 1) != 0 ? last - distance : last + distance;
    return true;
  });
}

}  // namespace

bool ReadHead(ByteReader& in, const ChunkForm& form, uint32_t points, WideTable* table,
              KnownConnectivity* known, ChunkHead* head) {
  if (!Is(in, {'D', 'R', 'A', 'C', 'O', kMajor})) return false;
  const uint32_t minor = in.Byte(), geometry = in.Byte();
  head->is_mesh = geometry == kMesh;
  if (geometry != kCloud && geometry != kMesh) return false;
  if (minor != (head->is_mesh ? kMeshMinor : kCloudMinor)) return false;
  if (in.Byte() != kSequential || in.Plain<uint16_t>() != 0) return false;
  if (!head->is_mesh) {
    if (in.Plain<uint32_t>() != points) return false;
  } else if (known->points == points && known->bytes.size() <= in.left() &&
             std::memcmp(known->bytes.data(), in.at(), known->bytes.size()) == 0) {
    (void)in.Skip(known->bytes.size());
    head->faces = known->faces;
  } else {
    const uint8_t* const begin = in.at();
    if (!ReadConnectivity(in, points, table, &head->faces)) return false;
    known->bytes.assign(begin, in.at());
    known->points = points;
    known->faces = head->faces;
  }
  const bool has_normals = form.normal_bits > 0;
  if (in.Byte() != 1 || in.Byte() != (has_normals ? 2u : 1u)) return false;
  if (!IsAttribute(in, kPositionType, 0)) return false;
  if (has_normals && !IsAttribute(in, kNormalType, 1)) return false;
  return in.Byte() == kQuantisedCoder && (!has_normals || in.Byte() == kOctahedralCoder) && in.ok();
}

bool ReadTail(ByteReader& in, const ChunkForm& form, const ChunkHead& head, uint64_t stream_bytes) {
  for (int axis = 0; axis < 3; ++axis) {
    if (in.Plain<float>() != 0) return false;
  }
  if (!(in.Plain<float>() > 0) || in.Byte() != static_cast<uint32_t>(form.position_bits)) {
    return false;
  }
  if (form.normal_bits > 0 && in.Byte() != static_cast<uint32_t>(form.normal_bits)) return false;
  if (!in.ok()) return false;
  if (in.left() == 0) return true;
  if (!head.is_mesh || stream_bytes != LeastMeshBytes(head.faces)) return false;
  return std::all_of(in.at(), in.at() + in.left(), [](uint8_t byte) { return byte == 0; });
}

}  // namespace latticed::decoder
