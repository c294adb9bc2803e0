// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Memory for reading one mesh file. A small file can become a large mesh: an index of a PLY strip takes one byte, and
// its triangle 16. Readers ask for memory before they allocate it, by announced counts where the format has them, and
// while the mesh grows where it has none.
//
//   ReadingMemory memory([&](uint64_t bytes) { return reservation.Resize("the mesh", bytes); });
//   auto mesh = ReadMesh(MeshFormat::kPly, bytes, &memory);
//
// Errors   those of the grant; reading ends with them
// Threads  one at a time
#ifndef LATTICED_CORE_MESH_READING_MEMORY_H_
#define LATTICED_CORE_MESH_READING_MEMORY_H_

#include <cstdint>
#include <functional>
#include <utility>

#include "absl/status/status.h"
#include "core/mesh/polygon_mesh.h"

namespace latticed {

class ReadingMemory {
 public:
  // Gets the bytes that reading takes in all, beside the file; they never fall.
  using Grant = std::function<absl::Status(uint64_t bytes)>;

  explicit ReadingMemory(Grant grant) : grant_(std::move(grant)) {}

  // Asks for `bytes` in all, if that is more than was granted before.
  [[nodiscard]] absl::Status Hold(uint64_t bytes);

 private:
  Grant grant_;
  uint64_t held_bytes_ = 0;
};

// Asks for the memory of a mesh whose vectors grow. A vector of n bytes that is full takes 2 n more, and gives n back
// once they are copied.
class MeshGrowth {
 public:
  // Memory is asked for once per so many appended bytes. A smaller mesh asks for none.
  static constexpr uint64_t kStepBytes = uint64_t{16} << 10;

  // `memory` may be null: everything is granted. `mesh` outlives this.
  MeshGrowth(ReadingMemory* memory, const PolygonMesh* mesh) : memory_(memory), mesh_(mesh) {}

  // Called before `bytes` are appended to the mesh's vectors. `beside` is what the reader itself has allocated.
  [[nodiscard]] absl::Status Append(uint64_t bytes, uint64_t beside = 0) {
    appended_bytes_ += bytes;
    return appended_bytes_ < kStepBytes ? absl::OkStatus() : Ask(beside);
  }
  // A name of a group is kept, which Append does not see.
  void NoteName(size_t size) { NoteNames(64 + size); }
  void NoteNames(uint64_t bytes) { name_bytes_ += bytes; }
  // Called before vectors are reserved that have `bytes` in the end, and before the reader allocates as much.
  [[nodiscard]] absl::Status Reserve(uint64_t bytes, uint64_t beside = 0);

 private:
  absl::Status Ask(uint64_t beside);
  // The most that the mesh takes while `coming` bytes are appended.
  uint64_t MostBytes(uint64_t coming) const;

  ReadingMemory* memory_;
  const PolygonMesh* mesh_;
  uint64_t appended_bytes_ = 0;  // since the mesh was looked at
  uint64_t name_bytes_ = 0;
};

}  // namespace latticed

#endif  // LATTICED_CORE_MESH_READING_MEMORY_H_
