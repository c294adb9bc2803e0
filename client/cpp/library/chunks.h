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
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "core/base/vec.h"
#include "latticed/v1/event.pb.h"
#include "latticed/v1/view.pb.h"

namespace latticed::client {

// Points in stream order: patch by patch, and within a patch in the order of TessellationPattern.points.
struct DecodedPoints {
  std::vector<Vec3d> positions;  // world
  std::vector<Vec3f> normals;    // unit, or empty
};

// A chunk as it came.
struct EncodedChunk {
  std::string_view data;
  size_t point_count = 0;  // that it must have
  const v1::Quantisation* quantisation = nullptr;
};

// Appends the points of the chunks to `points`. `view` is UpdateBegin.view, with all fields set. Draco streams that latticed
// did not write go to libdraco; the others take a quarter of its time, if eight or more come together.
[[nodiscard]] absl::Status DecodeChunks(std::span<const EncodedChunk> chunks,
                                        const v1::ViewOptions& view, DecodedPoints* points);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LIBRARY_CHUNKS_H_
