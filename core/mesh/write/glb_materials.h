// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The materials of a GLB file, with their textures, samplers and pictures, to be written into another GLB as they are.
//
// Pictures that are more than the whole file, because they overlap, are not kept, and neither are the materials.
// Of materials with the same name the first is taken, because groups are told by name. A texture of TEXCOORD_1 or higher is
// left out of its material, because only TEXCOORD_0 is kept. Names of extensions are kept where a material or a texture has them.
//
// Errors   none: what the source says wrongly is not there
// Threads  not safe: AddTo empties it
#ifndef LATTICED_CORE_MESH_WRITE_GLB_MATERIALS_H_
#define LATTICED_CORE_MESH_WRITE_GLB_MATERIALS_H_

#include <cstddef>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "core/mesh/glb_document.h"

namespace latticed {

class GlbMaterials {
 public:
  // Keeps a reference to `source`. Empty, or no GLB file: there are no materials.
  explicit GlbMaterials(std::string_view source);

  size_t count() const { return materials_.size(); }
  // The material that the reader made this group of.
  std::optional<size_t> Find(std::string_view group) const;
  // Of the pictures, with the gaps between them, and of the JSON that AddTo adds, at most.
  uint64_t PictureBytes() const { return picture_bytes_; }
  uint64_t MostJsonBytes() const { return json_bytes_; }
  // Sets `materials`, `textures`, `samplers` and `images` of `document`, and appends buffer views, and their bytes to
  // `binary`.
  void AddTo(nlohmann::json& document, std::string& binary) &&;

  // At least what making one from `source` takes, and what it adds to a file.
  static uint64_t MostBytes(std::string_view source);

 private:
  // Each buffer view once: several images may share one.
  uint64_t BytesOfPictures() const;
  void AddImages(nlohmann::json& document, std::string& binary) const;

  std::optional<GlbDocument> source_;
  nlohmann::json materials_ = nlohmann::json::array();
  std::map<std::string, size_t, std::less<>> by_group_;
  uint64_t picture_bytes_ = 0, json_bytes_ = 0;
};

}  // namespace latticed

#endif  // LATTICED_CORE_MESH_WRITE_GLB_MATERIALS_H_
