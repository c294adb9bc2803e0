// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Decodes chunks of every encoding to points in world coordinates.
//
//   position = Quantisation.origin + value            RAW: float32, added in double
//   position = Quantisation.origin + integer * step   QUANTISED, DRACO: in double
//
// Errors   kDataLoss for bytes that contradict the topology or the view
// Threads  pure functions
#ifndef LATTICED_CLIENT_CPP_LIBRARY_CHUNKS_H_
#define LATTICED_CLIENT_CPP_LIBRARY_CHUNKS_H_

#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "client/cpp/library/vertex_decoder.h"
#include "core/base/vec.h"
#include "latticed/v1/view.pb.h"

namespace latticed::client {

// Points in stream order: patch by patch, and within a patch in the order of TessellationPattern.points.
struct DecodedPoints {
  std::vector<Vec3d> positions;  // world
  std::vector<Vec3f> normals;    // unit, or empty
};

// `view` is UpdateBegin.view, with all fields set.
[[nodiscard]] absl::StatusOr<DecodedPoints> DecodeChunks(std::span<const EncodedChunk> chunks,
                                                         const v1::ViewOptions& view);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LIBRARY_CHUNKS_H_
