// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/codec/draco_decode.h"

#include <exception>
#include <memory>
#include <utility>

#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "core/codec/draco_announcement.h"
#include "draco/compression/decode.h"
#include "fmt/format.h"

namespace latticed {
namespace {

using Kind = draco::GeometryAttribute;

absl::Status MalformedChunk(std::string_view problem) {
  return error::MalformedFile("DRACO", "the stream", problem);
}

absl::StatusOr<std::unique_ptr<draco::PointCloud>> DecodeCloud(std::span<const uint8_t> bytes,
                                                               bool skip_transforms) {
  LATTICED_ASSIGN_OR_RETURN(const auto announcement, ReadDracoAnnouncement(bytes));
  if (announcement.points > limits::kMaxChunkPoints) {
    return MalformedChunk(fmt::format("announces {} points, a chunk has {} at most",
                                      announcement.points, limits::kMaxChunkPoints));
  }
  if (announcement.is_kd_tree) return MalformedChunk("is a k-d tree, a chunk keeps its order");
  LATTICED_RETURN_IF_ERROR(CheckDracoSize(announcement, bytes.size()));
  draco::Decoder decoder;
  if (skip_transforms) {
    decoder.SetSkipAttributeTransform(Kind::POSITION);
    decoder.SetSkipAttributeTransform(Kind::NORMAL);
  }
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  try {
    auto cloud = decoder.DecodePointCloudFromBuffer(&buffer);
    if (!cloud.ok()) return MalformedChunk(cloud.status().error_msg_string());
    return std::move(cloud).value();
  } catch (const std::exception& e) {  // std::bad_alloc and std::length_error of corrupt tables
    return MalformedChunk(e.what());
  }
}

// The values of an attribute by point. T must be how the attribute is stored.
template <typename T>
absl::StatusOr<std::vector<T>> Values(const draco::PointCloud& cloud, Kind::Type kind,
                                      int8_t components) {
  const draco::PointAttribute* attribute = cloud.GetNamedAttribute(kind);
  if (attribute == nullptr) return std::vector<T>{};
  if (attribute->num_components() != components)
    return MalformedChunk("has an unexpected attribute");
  const auto width = static_cast<size_t>(components);
  std::vector<T> values(width * cloud.num_points());
  for (uint32_t p = 0; p < cloud.num_points(); ++p) {
    const auto index = attribute->mapped_index(draco::PointIndex(p));
    if (!attribute->ConvertValue<T>(index, components, &values[width * p])) {
      return MalformedChunk("has an attribute value of another type");
    }
  }
  return values;
}

}  // namespace

absl::StatusOr<DecodedChunk> DecodeDracoChunk(std::span<const uint8_t> bytes) {
  LATTICED_ASSIGN_OR_RETURN(const auto cloud, DecodeCloud(bytes, /*skip_transforms=*/false));
  LATTICED_ASSIGN_OR_RETURN(auto positions, Values<float>(*cloud, Kind::POSITION, 3));
  LATTICED_ASSIGN_OR_RETURN(auto normals, Values<float>(*cloud, Kind::NORMAL, 3));
  if (positions.empty() && cloud->num_points() > 0) return MalformedChunk("has no positions");
  return DecodedChunk{std::move(positions), std::move(normals)};
}

absl::StatusOr<DecodedIntegers> DecodeDracoChunkIntegers(std::span<const uint8_t> bytes) {
  LATTICED_ASSIGN_OR_RETURN(const auto cloud, DecodeCloud(bytes, /*skip_transforms=*/true));
  LATTICED_ASSIGN_OR_RETURN(auto positions, Values<uint32_t>(*cloud, Kind::POSITION, 3));
  LATTICED_ASSIGN_OR_RETURN(auto normals, Values<uint32_t>(*cloud, Kind::NORMAL, 2));
  if (positions.empty() && cloud->num_points() > 0) return MalformedChunk("has no positions");
  return DecodedIntegers{std::move(positions), std::move(normals)};
}

}  // namespace latticed
