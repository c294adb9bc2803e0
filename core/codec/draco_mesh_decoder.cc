// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/codec/draco_mesh_decoder.h"

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/mesh/reading_memory.h"
#include "draco/compression/mesh/mesh_edgebreaker_decoder.h"
#include "draco/compression/mesh/mesh_sequential_decoder.h"
#include "draco/core/varint_decoding.h"

namespace latticed {
namespace {

// Twice what libdraco and the mesh made from it take, with positions, normals and UVs: 25 MB for 91,000 points and
// 180,000 faces by edgebreaker, 17 MB by the sequential method.
constexpr uint64_t kDecodedPointBytes = 256, kDecodedFaceBytes = 160;
// What these three attributes take of it, as AttributeSizes counts it, and their corner tables.
constexpr uint64_t kUsualAttributeBytes = 144, kUsualCornerTables = 2;
constexpr uint64_t kTableBytesPerFace = 64;  // 26 where the attribute never differs
// A point that edgebreaker makes because an attribute differs between the corners of a vertex.
constexpr uint64_t kBytesPerSplitPoint = 128;
// Objects of libdraco: per attribute, and per byte of metadata.
constexpr uint64_t kBytesPerAttribute = 1'024, kBytesPerMetadataByte = 64;

uint64_t Beyond(uint64_t value, uint64_t usual) { return value - std::min(value, usual); }

uint64_t AnnouncedBytes(const DracoAnnouncement& announced) {
  const uint64_t tables = Beyond(announced.corner_tables, kUsualCornerTables);
  return kDecodedPointBytes * announced.points +
         (kDecodedFaceBytes + kTableBytesPerFace * tables) * announced.faces +
         kBytesPerMetadataByte * announced.metadata_bytes;
}

struct AttributeSizes {
  uint64_t count = 0;
  uint64_t bytes_per_point = 0;
};

// Reads the headers of all attributes, which libdraco reads into objects. `buffer` is at the count of decoders.
bool ReadAttributeSizes(draco::DecoderBuffer buffer, bool is_edgebreaker, AttributeSizes& sizes) {
  constexpr uint64_t kBytesPerDecoder = 16;        // its order of points, and a map to its values
  constexpr uint64_t kMapBytes = 8;                // from points to values, twice
  constexpr uint64_t kIntegerBytes = 4;            // a component as it is decoded
  constexpr int64_t kEdgebreakerDecoderBytes = 3;  // in the stream: table, type, traversal
  constexpr int64_t kLeastAttributeBytes = 6;      // in the stream
  const auto skip = [&buffer](int64_t bytes) {
    if (buffer.remaining_size() < bytes) return false;
    buffer.Advance(bytes);
    return true;
  };
  uint8_t decoders = 0;
  if (!buffer.Decode(&decoders)) return false;
  if (is_edgebreaker && !skip(kEdgebreakerDecoderBytes * decoders)) return false;
  for (uint8_t d = 0; d < decoders; ++d) {
    uint32_t attributes = 0;
    if (buffer.bitstream_version() < DRACO_BITSTREAM_VERSION(2, 0)
            ? !buffer.Decode(&attributes)
            : !draco::DecodeVarint(&attributes, &buffer)) {
      return false;
    }
    if (attributes > buffer.remaining_size() / kLeastAttributeBytes) return false;
    sizes.count += attributes;
    sizes.bytes_per_point += kBytesPerDecoder;
    for (uint32_t a = 0; a < attributes; ++a) {
      uint8_t type = 0, data_type = 0, components = 0, normalized = 0;
      uint32_t id = 0;
      if (!buffer.Decode(&type) || !buffer.Decode(&data_type) || !buffer.Decode(&components) ||
          !buffer.Decode(&normalized) || !draco::DecodeVarint(&id, &buffer) ||
          data_type >= draco::DT_TYPES_COUNT) {
        return false;
      }
      const int bytes = draco::DataTypeLength(static_cast<draco::DataType>(data_type));
      if (bytes <= 0) return false;
      sizes.bytes_per_point +=
          components * (static_cast<uint64_t>(bytes) + kIntegerBytes) + kMapBytes;
    }
    if (!skip(attributes)) return false;  // how each is coded
  }
  return true;
}

// libdraco's decoder, which asks for its attributes' memory once their number and that of the points are known.
template <class Decoder>
class AskingDecoder : public Decoder {
 public:
  AskingDecoder(const DracoAnnouncement& announced, ReadingMemory* memory)
      : announced_(announced), memory_(memory) {}

  const absl::Status& refusal() const { return refusal_; }

 protected:
  bool DecodePointAttributes() override {
    AttributeSizes sizes;
    if (!ReadAttributeSizes(*this->buffer(), std::is_same_v<Decoder, draco::MeshEdgebreakerDecoder>,
                            sizes)) {
      return false;
    }
    if (memory_ != nullptr) refusal_ = memory_->Hold(Bytes(sizes));
    return refusal_.ok() && Decoder::DecodePointAttributes();
  }

 private:
  uint64_t Bytes(const AttributeSizes& sizes) {
    const uint64_t points = this->point_cloud()->num_points();
    return AnnouncedBytes(announced_) + kBytesPerAttribute * sizes.count +
           kBytesPerSplitPoint * Beyond(points, announced_.points) +
           points * Beyond(sizes.bytes_per_point, kUsualAttributeBytes);
  }

  const DracoAnnouncement announced_;
  ReadingMemory* const memory_;
  absl::Status refusal_;
};

template <class Decoder>
absl::StatusOr<std::unique_ptr<draco::Mesh>> Decode(const DracoAnnouncement& announced,
                                                    std::string_view bytes, ReadingMemory* memory) {
  if (memory != nullptr) LATTICED_RETURN_IF_ERROR(memory->Hold(AnnouncedBytes(announced)));
  AskingDecoder<Decoder> decoder(announced, memory);
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  auto mesh = std::make_unique<draco::Mesh>();
  const draco::Status status = decoder.Decode(draco::DecoderOptions(), &buffer, mesh.get());
  LATTICED_RETURN_IF_ERROR(decoder.refusal());
  if (!status.ok()) return error::MalformedFile("DRACO", "the stream", status.error_msg_string());
  return mesh;
}

}  // namespace

absl::StatusOr<std::unique_ptr<draco::Mesh>> DecodeDracoMesh(const DracoAnnouncement& announcement,
                                                             std::string_view bytes,
                                                             ReadingMemory* memory) {
  return announcement.is_edgebreaker
             ? Decode<draco::MeshEdgebreakerDecoder>(announcement, bytes, memory)
             : Decode<draco::MeshSequentialDecoder>(announcement, bytes, memory);
}

}  // namespace latticed
