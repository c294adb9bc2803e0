// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Functions that the readers of mesh files share: words, numbers and lines of text files, and the
// last checks.
//
// Threads  pure functions
#ifndef LATTICED_CORE_MESH_MESH_READING_H_
#define LATTICED_CORE_MESH_MESH_READING_H_

#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/vec.h"
#include "core/mesh/polygon_mesh.h"

namespace latticed {

// Removes the next word from *text and returns it. White space, line ends included, separates words. Empty at the end.
[[nodiscard]] std::string_view TakeWord(std::string_view* text);
// Removes the next line and its end (LF, CR LF or CR) from *text, and returns the line.
[[nodiscard]] std::string_view TakeTextLine(std::string_view* text);
// Whether the whole word is one number. Doubles must be finite; a leading '+' is allowed.
[[nodiscard]] bool ParseNumber(std::string_view word, double* value);
[[nodiscard]] bool ParseInteger(std::string_view word, int64_t* value);
// Why ParseNumber or ParseInteger refused the word; long and unprintable words are cut.
[[nodiscard]] std::string NumberProblem(std::string_view word);
// "line 12", for the position `offset` of a text. It counts lines from the start, so use it for error messages only.
[[nodiscard]] std::string LineAt(std::string_view text, size_t offset);
// A name of the file as a message may show it: printable, at most 40 characters.
[[nodiscard]] std::string Quoted(std::string_view word);

// Positions without duplicates, for formats that do not share vertices between faces. Two positions
// are one where all bits are equal; -0 counts as 0.
class VertexWelder {
 public:
  explicit VertexWelder(std::vector<Vec3d>* positions) : positions_(*positions) {}
  // Vertices of different weights stay apart.
  uint32_t Add(Vec3d position, float weight = 1);
  static constexpr uint64_t kNodeBytes = 64;  // of its table, for a position
  // Of its table: nodes, and pointers, which it copies to an array of twice the size.
  uint64_t MemoryBytes() const {
    return index_.size() * kNodeBytes + 3 * index_.bucket_count() * sizeof(void*);
  }

 private:
  struct Key {
    Vec3d position;
    float weight;
    friend bool operator==(const Key&, const Key&) = default;
  };
  struct Hash {
    size_t operator()(const Key& key) const;
  };
  std::vector<Vec3d>& positions_;
  std::unordered_map<Key, uint32_t, Hash> index_;
};

// Gives the last corner of `mesh` its attribute: `list` is corner_normals or corner_uvs, which stays
// empty until a corner has an attribute. FinishMesh fills up corners that come after the last one.
void AddCornerAttribute(const PolygonMesh& mesh, uint32_t index, std::vector<uint32_t>* list);

// Ends every reader: drops attributes that no corner uses, and validates. kInvalidArgument with
// reason MALFORMED_FILE.
[[nodiscard]] absl::StatusOr<PolygonMesh> FinishMesh(std::string_view format, PolygonMesh mesh);

}  // namespace latticed

#endif  // LATTICED_CORE_MESH_MESH_READING_H_
