// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The JSON of a GLB file, and its accessors as checked views of the BIN chunk.
//
// The functions below look up a member of a JSON value and never throw. A member of another type
// counts as a wrong one where it is an index or a size, else as absent.
//
// Errors   kInvalidArgument, reason MALFORMED_FILE, naming the byte or the glTF element
// Threads  a document is immutable once made
#ifndef LATTICED_CORE_MESH_GLB_DOCUMENT_H_
#define LATTICED_CORE_MESH_GLB_DOCUMENT_H_

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "core/mesh/reading_memory.h"

namespace latticed {

// kInvalidArgument, reason MALFORMED_FILE.
[[nodiscard]] absl::Status MalformedGlb(std::string_view where, std::string_view problem);

// The member, or null where there is none.
[[nodiscard]] const nlohmann::json& GlbMember(const nlohmann::json& object, const char* key);
// The member, or null where there is none. Null iterates like an empty array.
[[nodiscard]] const nlohmann::json& GlbArray(const nlohmann::json& object, const char* key);
// The index that a member holds: kGlbNoIndex if it is absent, a smaller number if it is no index.
inline constexpr int64_t kGlbNoIndex = -1;
[[nodiscard]] int64_t GlbIndex(const nlohmann::json& object, const char* key);
[[nodiscard]] std::vector<int64_t> GlbIndices(const nlohmann::json& object, const char* key);
[[nodiscard]] std::vector<double> GlbNumbers(const nlohmann::json& object, const char* key);
[[nodiscard]] std::string GlbString(const nlohmann::json& object, const char* key);

struct GlbComponentType {
  int number;      // of glb_layout.h
  size_t bytes;    // of one component
  double largest;  // what a normalised 1 is stored as; 0 for types that are never normalised
  double (*load)(const char* bytes);
};

// Elements of one accessor inside the buffer; all `count` lie within it.
struct GlbAccessor {
  const char* data = nullptr;
  size_t count = 0;
  size_t stride = 0;  // bytes from one element to the next
  const GlbComponentType* type = nullptr;
  bool normalized = false;

  // Component c of element i; a normalised integer in -1 … 1.
  [[nodiscard]] double Component(size_t i, size_t c) const;
  [[nodiscard]] size_t Index(size_t i) const;
};

class GlbDocument {
 public:
  // Keeps a reference to `bytes`. `memory` may be null.
  static absl::StatusOr<GlbDocument> Parse(std::string_view bytes, ReadingMemory* memory);

  const nlohmann::json& root() const { return root_; }
  // More than the tree of root() takes.
  uint64_t memory_bytes() const { return memory_bytes_; }
  // The bytes of a buffer view; none if it does not exist or leaves the buffer.
  [[nodiscard]] std::string_view BufferView(int64_t index) const;
  // More than the tree of such a file takes, by the size of its JSON.
  [[nodiscard]] static uint64_t TreeBytes(std::string_view file);
  [[nodiscard]] static uint64_t JsonBytes(std::string_view file);
  // Opens accessor `index`. It must exist, be dense, lie in its buffer, and have this many components.
  [[nodiscard]] absl::StatusOr<GlbAccessor> Open(int64_t index, int components) const;
  // The same for vertex indices, which are unsigned integers.
  [[nodiscard]] absl::StatusOr<GlbAccessor> OpenIndices(int64_t index) const;

 private:
  GlbDocument(nlohmann::json root, uint64_t memory_bytes, std::string_view buffer)
      : root_(std::move(root)), memory_bytes_(memory_bytes), buffer_(buffer) {}

  nlohmann::json root_;
  uint64_t memory_bytes_;
  std::string_view buffer_;
};

}  // namespace latticed

#endif  // LATTICED_CORE_MESH_GLB_DOCUMENT_H_
