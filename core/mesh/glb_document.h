// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A GLB file as tinygltf's model, reduced to geometry, and its accessors as checked views.
//
// The JSON is checked before tinygltf sees it (which recurses, copies buffers, opens files):
// bounded nesting; only scenes, nodes, meshes, material names, accessors and one buffer, the BIN
// chunk, go on.
//
// Errors   kInvalidArgument, reason MALFORMED_FILE, naming the byte or the glTF element
// Threads  a document is immutable once made
#ifndef LATTICED_CORE_MESH_GLB_DOCUMENT_H_
#define LATTICED_CORE_MESH_GLB_DOCUMENT_H_

#include <cstddef>
#include <memory>
#include <string_view>

#include "absl/status/statusor.h"

namespace tinygltf {
class Model;
}

namespace latticed {

// Elements of one accessor inside the buffer; all `count` lie within it.
struct GlbAccessor {
  const unsigned char* data = nullptr;
  size_t count = 0;
  size_t stride = 0;       // bytes from one element to the next
  int component_type = 0;  // of glb_layout.h
  int components = 0;      // a element: 1 … 4
  bool normalized = false;

  // Component c of element i; a normalised integer in -1 … 1.
  [[nodiscard]] double Component(size_t i, int c) const;
  [[nodiscard]] size_t Index(size_t i) const;
};

class GlbDocument {
 public:
  static absl::StatusOr<GlbDocument> Parse(std::string_view bytes);
  GlbDocument(GlbDocument&&) noexcept;
  GlbDocument& operator=(GlbDocument&&) noexcept;
  ~GlbDocument();

  const tinygltf::Model& model() const { return *model_; }
  // Accessor `index`, which must exist, be dense, lie in its buffer, and have so many components.
  [[nodiscard]] absl::StatusOr<GlbAccessor> Open(int index, int components) const;
  // The same for vertex indices, which are unsigned integers.
  [[nodiscard]] absl::StatusOr<GlbAccessor> OpenIndices(int index) const;

 private:
  GlbDocument();

  std::unique_ptr<tinygltf::Model> model_;
};

}  // namespace latticed

#endif  // LATTICED_CORE_MESH_GLB_DOCUMENT_H_
