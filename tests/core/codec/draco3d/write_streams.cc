// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Usage: draco3d_write_streams FOLDER. Writes streams of our writer, and beside each the integers
// that it must hold, for another decoder to compare (compare_streams.mjs):
//
//   N_P_Q.drc  the stream, positions of P bits and normals of Q (0: none), written alone or in a group, as a server does; about a third are meshes, and every second of
//              those written alone may use the scheme TAGGED
//   N_P_Q.meshopt  the same vertices as a stream of ENCODING_MESHOPT
//   N_P_Q.bin  little-endian uint32: position values of all points, x y z each; then s t of normals
#include <array>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "core/codec/chunk_connectivity.h"
#include "core/codec/meshopt/meshopt_writer.h"
#include "fmt/format.h"
#include "tests/core/codec/chunk_fixtures.h"
#include "tests/support/encode_chunk.h"

namespace latticed::testing {
namespace {

constexpr unsigned kSeed = 31;

template <class T>
bool WriteBytes(const std::string& path, const std::vector<T>& values) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(values.data()),
             static_cast<std::streamsize>(values.size() * sizeof(T)));
  return file.good();
}

bool WriteFiles(const std::string& folder, unsigned number, const Chunk& chunk,
                const std::vector<uint8_t>& stream) {
  std::vector<uint32_t> values = chunk.integers.positions;
  values.insert(values.end(), chunk.integers.normals.begin(), chunk.integers.normals.end());
  const std::string path =
      fmt::format("{}/{}_{}_{}", folder, number, chunk.position_bits, chunk.normal_bits);
  return WriteBytes(path + ".drc", stream) && WriteBytes(path + ".bin", values) &&
         WriteBytes(path + ".meshopt", EncodeMeshopt(chunk.vertices()));
}

bool WriteStream(const std::string& folder, unsigned number, const Chunk& chunk) {
  const auto encoder = MakeChunkEncoder("latticed");
  QuantisedVertices vertices = chunk.vertices();
  vertices.is_sparse = number % 2 == 1;
  const auto stream = number % 3 == 2 && chunk.points > 2
                          ? testing::EncodeMesh(*encoder, vertices, 8.0, Fan(chunk.points))
                          : testing::EncodePoints(*encoder, vertices, 8.0);
  return stream.ok() && WriteFiles(folder, number, chunk, *stream);
}

// Writes one full batch of the writer's chunks, with all kinds of data in turn, numbered from
// `number` on.
bool WriteGroup(const std::string& folder, size_t points, int position_bits, int normal_bits,
                bool meshes, unsigned& number) {
  const auto encoder = MakeChunkEncoder("latticed");
  std::vector<Chunk> chunks;
  std::vector<QuantisedVertices> vertices;
  for (unsigned i = 0; i < encoder->batch(); ++i) {
    chunks.push_back(MakeChunk(points, position_bits, normal_bits,
                               kAllData[i % std::size(kAllData)], kSeed + number + i));
  }
  for (const Chunk& chunk : chunks) vertices.push_back(chunk.vertices());
  const ChunkConnectivity fan(points, Fan(points));
  std::vector<std::vector<uint8_t>> streams(chunks.size());
  if (!encoder->Encode(vertices, 8.0, meshes ? &fan : nullptr, streams).ok()) return false;
  for (size_t i = 0; i < chunks.size(); ++i) {
    if (!WriteFiles(folder, number++, chunks[i], streams[i])) return false;
  }
  return true;
}

// Writes every kind of data in its own chunk, numbered from `number` on.
bool WriteAllData(const std::string& folder, size_t points, int position_bits, int normal_bits,
                  unsigned& number) {
  for (const Data data : kAllData) {
    const Chunk chunk = MakeChunk(points, position_bits, normal_bits, data, kSeed + number);
    if (!WriteStream(folder, number++, chunk)) return false;
  }
  return true;
}

// Every pair of bits for the points of one patch, alone and in groups. Chunks of one point, of the
// usual size, of 4,096 patches of 1 segment, of 32 patches of 32 segments, and of the largest
// number of points. Groups of the usual size.
bool WriteStreams(const std::string& folder) {
  unsigned number = 0;
  for (int position_bits = 8; position_bits <= 16; ++position_bits) {
    for (const int normal_bits : {0, 6, 7, 8, 9, 10, 11, 12}) {
      const bool meshes = (position_bits + normal_bits) % 3 == 0;
      if (!WriteAllData(folder, 66, position_bits, normal_bits, number) ||
          !WriteGroup(folder, 66, position_bits, normal_bits, meshes, number)) {
        return false;
      }
    }
  }
  for (const size_t points : {1u, 2112u, 4096u * 3, 32u * 561, 65'535u}) {
    for (const auto& [position_bits, normal_bits] : {std::pair(12, 8), std::pair(16, 12)}) {
      if (!WriteAllData(folder, points, position_bits, normal_bits, number)) return false;
    }
  }
  return WriteGroup(folder, 2112, 12, 8, /*meshes=*/false, number) &&
         WriteGroup(folder, 2112, 14, 10, /*meshes=*/true, number);
}

}  // namespace
}  // namespace latticed::testing

int main(int argc, char** argv) {
  if (argc == 2 && latticed::testing::WriteStreams(argv[1])) return 0;
  std::fputs("usage: draco3d_write_streams FOLDER (writable)\n", stderr);
  return 1;
}
