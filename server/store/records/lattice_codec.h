// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Lattices and lists of points <-> scene_log.proto, bit by bit.
//
// Errors   kDataLoss for counts that do not agree
// Threads  pure functions
#ifndef LATTICED_SERVER_STORE_RECORDS_LATTICE_CODEC_H_
#define LATTICED_SERVER_STORE_RECORDS_LATTICE_CODEC_H_

#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/vec.h"
#include "core/ffd/lattice.h"
#include "server/store/records/scene_log.pb.h"

namespace latticed {

// The status of bytes that no encoder made.
[[nodiscard]] absl::Status NotARecord(std::string_view what);

void ToStored(const Lattice& lattice, store::Lattice& stored);
// The result is not validated.
[[nodiscard]] absl::StatusOr<Lattice> LatticeFromStored(const store::Lattice& stored);

void ToStored(const std::vector<Vec3d>& points, google::protobuf::RepeatedField<double>& flat);
[[nodiscard]] absl::StatusOr<std::vector<Vec3d>> PointsFromStored(
    const google::protobuf::RepeatedField<double>& flat);

}  // namespace latticed

#endif  // LATTICED_SERVER_STORE_RECORDS_LATTICE_CODEC_H_
