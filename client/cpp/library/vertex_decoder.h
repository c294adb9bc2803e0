// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Decodes chunks of every encoding straight into the caller's memory, a vertex buffer for instance. It allocates nothing per
// chunk.
//
//   GridVertex      position = Quantisation.origin + (x, y, z) * step; s t is the octahedral normal
//   WorldVertex     position and unit normal in world coordinates, computed in double and rounded to float32
//   DecodedPoints   positions in double: vectors that grow, for those who need the precision
//
// Normals are 0 in views without normals. Draco streams that latticed did not write go to libdraco. The others take a
// sixth of its time if eight or more come together.
//
// Errors   kDataLoss for bytes that contradict the topology or the view; what was written then means nothing.
//          kInvalidArgument for memory of another size; for GridVertex and ENCODING_RAW, which has no grid
// Threads  one decoder: one at a time. Its memory is kept from one call to the next, so keep one for each thread
#ifndef LATTICED_CLIENT_CPP_LIBRARY_VERTEX_DECODER_H_
#define LATTICED_CLIENT_CPP_LIBRARY_VERTEX_DECODER_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "core/base/vec.h"
#include "latticed/v1/event.pb.h"
#include "latticed/v1/view.pb.h"

namespace latticed::client {

// A chunk as it came.
struct EncodedChunk {
  std::string_view data;
  size_t point_count = 0;  // that it must have
  const v1::Quantisation* quantisation = nullptr;
};

// The viewer's layout.
struct GridVertex {
  uint16_t x = 0, y = 0, z = 0, padding = 0, s = 0, t = 0;
  friend bool operator==(const GridVertex&, const GridVertex&) = default;
};

struct WorldVertex {
  Vec3f position, normal;
  friend bool operator==(const WorldVertex&, const WorldVertex&) = default;
};

struct DecodedPoints {
  std::vector<Vec3d> positions;  // world
  std::vector<Vec3f> normals;    // unit, or empty
};

class VertexDecoder {
 public:
  VertexDecoder();
  VertexDecoder(const VertexDecoder&) = delete;  // its memory is large, and a copy is of no use
  VertexDecoder& operator=(const VertexDecoder&) = delete;
  ~VertexDecoder();

  // Write the points of the chunks one after the other: in stream order, patch by patch, and within a patch in the order of
  // its pattern's points. `view` is UpdateBegin.view, with all fields set.
  [[nodiscard]] absl::Status Decode(std::span<const EncodedChunk> chunks,
                                    const v1::ViewOptions& view, std::span<GridVertex> vertices);
  [[nodiscard]] absl::Status Decode(std::span<const EncodedChunk> chunks,
                                    const v1::ViewOptions& view, std::span<WorldVertex> vertices);
  // Appends the same points in double.
  [[nodiscard]] absl::Status Decode(std::span<const EncodedChunk> chunks,
                                    const v1::ViewOptions& view, DecodedPoints* points);

 private:
  struct Workspace;
  const std::unique_ptr<Workspace> workspace_;
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LIBRARY_VERTEX_DECODER_H_
