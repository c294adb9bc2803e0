// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/codec/draco_announcement.h"

#include <cstring>
#include <utility>

#include "core/base/error.h"
#include "core/base/limits.h"
#include "draco/compression/config/compression_shared.h"
#include "draco/core/decoder_buffer.h"
#include "draco/core/varint_decoding.h"
#include "fmt/format.h"

namespace latticed {
namespace {

// "DRACO", major, minor, geometry type, method, uint16 flags.
constexpr size_t kHeaderBytes = 11;
// Entropy coding can go below a bit an element, but no real mesh comes near this.
constexpr uint64_t kMaxElementsPerByte = 1024;
constexpr uint16_t kVarintCounts = DRACO_BITSTREAM_VERSION(2, 2);

absl::Status Malformed(std::string_view where, std::string_view problem) {
  return error::MalformedFile("DRACO", where, problem);
}

// Counts are varints since 2.2, uint32 before.
bool ReadCount(uint16_t version, draco::DecoderBuffer& buffer, uint64_t& count) {
  uint32_t value = 0;
  const bool ok =
      version >= kVarintCounts ? draco::DecodeVarint(&value, &buffer) : buffer.Decode(&value);
  count = value;
  return ok;
}

bool Skip(draco::DecoderBuffer& buffer, uint64_t bytes) {
  if (static_cast<uint64_t>(buffer.remaining_size()) < bytes) return false;
  buffer.Advance(static_cast<int64_t>(bytes));
  return true;
}

bool SkipName(draco::DecoderBuffer& buffer) {
  uint8_t length = 0;
  return buffer.Decode(&length) && Skip(buffer, length);
}

bool SkipEntry(draco::DecoderBuffer& buffer) {
  uint32_t bytes = 0;
  return SkipName(buffer) && draco::DecodeVarint(&bytes, &buffer) && Skip(buffer, bytes);
}

// One tree of metadata: entries, and named trees.
bool SkipMetadataTree(draco::DecoderBuffer& buffer) {
  constexpr uint64_t kLeastTreeBytes = 3;  // an empty name and two counts
  bool is_root = true;
  for (uint64_t trees = 1; trees > 0; --trees) {
    uint32_t entries = 0, subtrees = 0;
    if (!std::exchange(is_root, false) && !SkipName(buffer)) return false;
    if (!draco::DecodeVarint(&entries, &buffer)) return false;
    for (uint32_t i = 0; i < entries; ++i) {
      if (!SkipEntry(buffer)) return false;
    }
    if (!draco::DecodeVarint(&subtrees, &buffer)) return false;
    trees += subtrees;
    const auto left = static_cast<uint64_t>(buffer.remaining_size());
    if ((trees - 1) * kLeastTreeBytes > left) return false;
  }
  return true;
}

bool SkipMetadata(draco::DecoderBuffer& buffer) {
  uint32_t attributes = 0, id = 0;
  if (!draco::DecodeVarint(&attributes, &buffer)) return false;
  for (uint32_t i = 0; i < attributes; ++i) {
    if (!draco::DecodeVarint(&id, &buffer) || !SkipMetadataTree(buffer)) return false;
  }
  return SkipMetadataTree(buffer);
}

bool ReadCounts(uint16_t version, bool is_mesh, uint8_t method, draco::DecoderBuffer& buffer,
                DracoAnnouncement& announcement) {
  if (!is_mesh) {
    int32_t points = 0;  // both methods of point clouds
    if (!buffer.Decode(&points) || points < 0) return false;
    announcement.points = static_cast<uint64_t>(points);
    return true;
  }
  if (method == draco::MESH_SEQUENTIAL_ENCODING) {
    return ReadCount(version, buffer, announcement.faces) &&
           ReadCount(version, buffer, announcement.points);
  }
  uint8_t traversal = 0, corner_tables = 0;
  uint64_t new_vertices = 0;  // only before 2.2
  const bool ok = buffer.Decode(&traversal) &&
                  (version >= kVarintCounts || ReadCount(version, buffer, new_vertices)) &&
                  ReadCount(version, buffer, announcement.points) &&
                  ReadCount(version, buffer, announcement.faces) && buffer.Decode(&corner_tables);
  announcement.corner_tables = corner_tables;
  return ok;
}

}  // namespace

absl::StatusOr<DracoAnnouncement> ReadDracoAnnouncement(std::span<const uint8_t> bytes) {
  if (bytes.size() < kHeaderBytes) return Malformed("byte 0", "shorter than the header");
  if (std::memcmp(bytes.data(), "DRACO", 5) != 0) {
    return Malformed("byte 0", "does not begin with 'DRACO'");
  }
  const uint16_t version = DRACO_BITSTREAM_VERSION(bytes[5], bytes[6]);
  const uint8_t geometry = bytes[7], method = bytes[8];
  if (geometry > draco::TRIANGULAR_MESH || method > 1) {
    return Malformed("byte 7",
                     fmt::format("unknown geometry type {} or method {}", geometry, method));
  }
  const uint16_t flags = static_cast<uint16_t>(bytes[9] | bytes[10] << 8);
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes.data()) + kHeaderBytes,
              bytes.size() - kHeaderBytes, version);
  DracoAnnouncement announcement{.is_mesh = geometry == draco::TRIANGULAR_MESH};
  if ((flags & METADATA_FLAG_MASK) != 0) {
    if (!SkipMetadata(buffer)) return Malformed("byte 11", "its metadata cannot be read");
    announcement.metadata_bytes = static_cast<uint64_t>(buffer.decoded_size());
  }
  announcement.is_edgebreaker = announcement.is_mesh && method == draco::MESH_EDGEBREAKER_ENCODING;
  announcement.is_kd_tree = !announcement.is_mesh && method == draco::POINT_CLOUD_KD_TREE_ENCODING;
  if (!ReadCounts(version, announcement.is_mesh, method, buffer, announcement)) {
    return Malformed(fmt::format("byte {}", bytes.size()), "ends before its counts");
  }
  return announcement;
}

absl::Status CheckDracoSize(const DracoAnnouncement& announcement, size_t byte_count) {
  const uint64_t held = kMaxElementsPerByte * byte_count;
  if (announcement.points > held || announcement.faces > held) {
    return Malformed("its header",
                     fmt::format("announces {} points and {} faces in {} bytes",
                                 announcement.points, announcement.faces, byte_count));
  }
  if (announcement.points > limits::kMaxMeshVertices ||
      announcement.faces > limits::kMaxMeshFaces) {
    return Malformed(
        "its header",
        fmt::format("announces {} points and {} faces, allowed are {} and {}", announcement.points,
                    announcement.faces, limits::kMaxMeshVertices, limits::kMaxMeshFaces));
  }
  return absl::OkStatus();
}

}  // namespace latticed
