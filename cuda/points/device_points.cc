// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/points/device_points.h"

#include <algorithm>
#include <span>

#include "core/base/status_macros.h"
#include "cuda/device/device_reservation.h"
#include "cuda/device/table_upload.h"

namespace latticed {
namespace {

constexpr char kPointsPurpose[] = "points";

struct PieceTables {
  std::vector<kernels::PointPiece> pieces;
  std::vector<uint32_t> first_piece, boxes;  // by slot
  std::vector<LocalMap> maps;

  uint64_t Bytes() const {
    return TableUpload::BlockBytes({pieces.size() * sizeof(kernels::PointPiece),
                                    first_piece.size() * sizeof(uint32_t),
                                    maps.size() * sizeof(LocalMap)});
  }
};

// The runs of a box follow each other.
PieceTables MakePieces(const SortedPoints& points) {
  PieceTables tables;
  for (const SortedPoints::Run& run : points.runs()) {
    if (tables.boxes.empty() || tables.boxes.back() != run.box) {
      tables.boxes.push_back(run.box);
      tables.first_piece.push_back(static_cast<uint32_t>(tables.pieces.size()));
      tables.maps.push_back(points.boxes().MapOf(run.box));
    }
    const auto slot = static_cast<uint32_t>(tables.boxes.size() - 1);
    for (uint32_t done = 0; done < run.count; done += kernels::kPiecePoints) {
      tables.pieces.push_back(
          {run.first + done, std::min(kernels::kPiecePoints, run.count - done), slot});
    }
  }
  tables.first_piece.push_back(static_cast<uint32_t>(tables.pieces.size()));
  return tables;
}

}  // namespace

absl::StatusOr<DevicePoints> DevicePoints::Create(const SortedPoints& points,
                                                  CudaContext& context) {
  const cudaStream_t stream = context.stream().get();
  PieceTables pieces = MakePieces(points);
  DevicePoints result;
  result.bytes_ =
      SortedPoints::BytesFor(points.size(), points.has_normals(), false) + pieces.Bytes();
  LATTICED_ASSIGN_OR_RETURN(
      auto room, DeviceReservation::Create(context.memory(), "the point set", result.bytes_));
  kernels::PointTables& tables = result.tables_;
  for (size_t axis = 0; axis < (points.has_normals() ? 6 : 3); ++axis) {
    const double* const from = axis < 3 ? points.world(axis) : points.normal(axis - 3);
    LATTICED_ASSIGN_OR_RETURN(
        result.coordinates_[axis],
        DeviceBuffer<double>::Upload(room, kPointsPurpose, std::span(from, points.size()), stream));
    (axis < 3 ? tables.world[axis] : tables.normal[axis - 3]) = result.coordinates_[axis].data();
  }
  LATTICED_ASSIGN_OR_RETURN(
      result.order_,
      DeviceBuffer<uint32_t>::Upload(room, kPointsPurpose, std::span(points.order()), stream));
  tables.order = result.order_.data();
  tables.points = points.size();
  tables.inside = points.inside();
  tables.piece_count = static_cast<uint32_t>(pieces.pieces.size());
  tables.slot_count = static_cast<uint32_t>(pieces.boxes.size());
  std::ranges::copy(points.boxes().structure().degree, tables.degree);
  result.boxes_ = std::move(pieces.boxes);

  TableUpload upload;
  upload.Add(std::move(pieces.pieces), tables.pieces);
  upload.Add(std::move(pieces.first_piece), tables.first_piece);
  upload.Add(std::move(pieces.maps), tables.maps);
  LATTICED_ASSIGN_OR_RETURN(result.small_, upload.Send(room, kPointsPurpose, stream));
  LATTICED_RETURN_IF_ERROR(context.stream().Synchronize("the point set"));
  return result;
}

}  // namespace latticed
