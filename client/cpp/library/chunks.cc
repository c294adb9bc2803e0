// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/library/chunks.h"

#include <cstring>

#include "core/codec/draco_decode.h"
#include "core/codec/octahedral.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

Vec3d Origin(const v1::Quantisation& quantisation) {
  return {quantisation.origin().x(), quantisation.origin().y(), quantisation.origin().z()};
}

absl::Status WrongSize(std::string_view encoding, size_t got, size_t expected) {
  return absl::DataLossError(
      fmt::format("a {} chunk holds {} values or bytes instead of {}", encoding, got, expected));
}

bool HasNormals(const v1::ViewOptions& view) { return view.normals() != v1::NORMAL_MODE_NONE; }

absl::Status DecodeRaw(std::string_view data, size_t point_count, const v1::ViewOptions& view,
                       Vec3d origin, DecodedPoints* points) {
  const size_t floats = HasNormals(view) ? 6 : 3;
  if (data.size() != point_count * floats * sizeof(float)) {
    return WrongSize("RAW", data.size(), point_count * floats * sizeof(float));
  }
  for (size_t i = 0; i < point_count; ++i) {
    float value[6];
    std::memcpy(value, data.data() + i * floats * sizeof(float), floats * sizeof(float));
    points->positions.push_back(origin + ToDouble({value[0], value[1], value[2]}));
    if (floats == 6) points->normals.push_back({value[3], value[4], value[5]});
  }
  return absl::OkStatus();
}

// Returns value i of a plane with `width` bytes per value, little endian.
uint32_t PlaneValue(std::string_view plane, size_t width, size_t i) {
  uint32_t value = 0;
  std::memcpy(&value, plane.data() + width * i, width);
  return value;
}

absl::Status DecodeQuantised(std::string_view data, size_t point_count, const v1::ViewOptions& view,
                             Vec3d origin, const v1::Quantisation& quantisation,
                             DecodedPoints* points) {
  const size_t width = !HasNormals(view) ? 0 : quantisation.normal_bits() <= 8 ? 1 : 2;
  if (data.size() != point_count * (6 + 2 * width)) {
    return WrongSize("QUANTISED", data.size(), point_count * (6 + 2 * width));
  }
  const auto plane = [&](size_t begin) { return data.substr(begin * point_count); };
  for (size_t i = 0; i < point_count; ++i) {
    const Vec3d integers{static_cast<double>(PlaneValue(plane(0), 2, i)),
                         static_cast<double>(PlaneValue(plane(2), 2, i)),
                         static_cast<double>(PlaneValue(plane(4), 2, i))};
    points->positions.push_back(origin + integers * quantisation.step());
    if (width == 0) continue;
    points->normals.push_back(
        DequantiseNormal({static_cast<int32_t>(PlaneValue(plane(6), width, i)),
                          static_cast<int32_t>(PlaneValue(plane(6 + width), width, i))},
                         quantisation.normal_bits()));
  }
  return absl::OkStatus();
}

absl::Status DecodeDraco(std::string_view data, size_t point_count, const v1::ViewOptions& view,
                         Vec3d origin, const v1::Quantisation& quantisation,
                         DecodedPoints* points) {
  const auto decoded =
      DecodeDracoChunkIntegers({reinterpret_cast<const uint8_t*>(data.data()), data.size()});
  if (!decoded.ok()) return absl::DataLossError(std::string(decoded.status().message()));
  const size_t normal_values = HasNormals(view) ? 2 * point_count : 0;
  if (decoded->positions.size() != 3 * point_count) {
    return WrongSize("DRACO", decoded->positions.size(), 3 * point_count);
  }
  if (decoded->normals.size() != normal_values) {
    return WrongSize("DRACO", decoded->normals.size(), normal_values);
  }
  for (size_t i = 0; i < point_count; ++i) {
    const uint32_t* p = &decoded->positions[3 * i];
    points->positions.push_back(origin + Vec3d{double(p[0]), double(p[1]), double(p[2])} *
                                             quantisation.step());
    if (normal_values == 0) continue;
    points->normals.push_back(DequantiseNormal({static_cast<int32_t>(decoded->normals[2 * i]),
                                                static_cast<int32_t>(decoded->normals[2 * i + 1])},
                                               quantisation.normal_bits()));
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status DecodeChunk(std::string_view data, size_t point_count, const v1::ViewOptions& view,
                         const v1::Quantisation& quantisation, DecodedPoints* points) {
  const Vec3d origin = Origin(quantisation);
  switch (view.encoding()) {
    case v1::ENCODING_RAW:
      return DecodeRaw(data, point_count, view, origin, points);
    case v1::ENCODING_QUANTISED:
      return DecodeQuantised(data, point_count, view, origin, quantisation, points);
    case v1::ENCODING_DRACO_POINTS:
    case v1::ENCODING_DRACO_MESH:
      return DecodeDraco(data, point_count, view, origin, quantisation, points);
    default:
      return absl::DataLossError(
          fmt::format("the server sent encoding {}, which this client does not know",
                      static_cast<int>(view.encoding())));
  }
}

}  // namespace latticed::client
