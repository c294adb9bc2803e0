// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/mesh/write/glb_materials.h"

#include <set>
#include <utility>

#include "core/mesh/glb_layout.h"
#include "core/mesh/little_endian.h"
#include "fmt/format.h"

namespace latticed {
namespace {

using nlohmann::json;

// Which set of texture coordinates a texture of a material takes (textureInfo of glTF; KHR_texture_transform may say
// another).
int64_t TexCoordOf(const json& texture_info) {
  const json& transform = GlbMember(GlbMember(texture_info, "extensions"), "KHR_texture_transform");
  const int64_t other = GlbIndex(transform, "texCoord");
  return other == kGlbNoIndex ? GlbIndex(texture_info, "texCoord") : other;
}

// Its depth is that of the source, which GlbDocument bounds.
void RemoveOtherTexCoords(json& object) {
  if (object.is_array()) {
    for (json& element : object) RemoveOtherTexCoords(element);
  }
  if (!object.is_object()) return;
  for (auto it = object.begin(); it != object.end();) {
    const bool is_texture = it->is_object() && it->contains("index");
    if (is_texture && TexCoordOf(*it) > 0) {
      it = object.erase(it);
    } else {
      RemoveOtherTexCoords(*it);
      ++it;
    }
  }
}

// The members of all objects.
void AddKeys(const json& value, std::set<std::string, std::less<>>* keys) {
  if (!value.is_structured()) return;
  for (const auto& [key, element] : value.items()) {
    if (value.is_object()) keys->insert(key);
    AddKeys(element, keys);
  }
}

// "1e9" becomes "1000000000.0".
uint64_t MostTextBytes(std::string_view source) {
  constexpr uint64_t kGrowth = 6;
  return kGrowth * GlbDocument::JsonBytes(source);
}

}  // namespace

GlbMaterials::GlbMaterials(std::string_view source) {
  if (source.empty()) return;
  auto document = GlbDocument::Parse(source, nullptr);
  if (!document.ok()) return;
  source_ = *std::move(document);
  materials_ = GlbArray(source_->root(), "materials");
  for (size_t i = 0; i < materials_.size(); ++i) {
    const std::string name = GlbString(materials_[i], "name");
    by_group_.try_emplace(name.empty() ? fmt::format("material {}", i) : name, i);
    RemoveOtherTexCoords(materials_[i]);
  }
  if (materials_.empty()) {
    source_.reset();
    return;
  }
  picture_bytes_ = BytesOfPictures();
  json_bytes_ = MostTextBytes(source);
  if (picture_bytes_ <= source.size()) return;
  materials_.clear();
  by_group_.clear();
  picture_bytes_ = json_bytes_ = 0;
  source_.reset();
}

uint64_t GlbMaterials::BytesOfPictures() const {
  std::set<int64_t> views;
  for (const json& image : GlbArray(source_->root(), "images")) {
    views.insert(GlbIndex(image, "bufferView"));
  }
  uint64_t bytes = 0;
  for (const int64_t view : views) bytes += glb::Aligned(source_->BufferView(view).size());
  return bytes;
}

std::optional<size_t> GlbMaterials::Find(std::string_view group) const {
  const auto found = by_group_.find(group);
  if (found == by_group_.end()) return std::nullopt;
  return found->second;
}

void GlbMaterials::AddImages(json& document, std::string& binary) const {
  std::map<int64_t, size_t> written;  // views of the source
  for (json image : GlbArray(source_->root(), "images")) {
    if (!image.is_object()) image = json::object();  // textures name images by number
    const int64_t view = GlbIndex(image, "bufferView");
    const std::string_view picture = source_->BufferView(view);
    if (!picture.empty() && !written.contains(view)) {
      binary.resize(glb::Aligned(binary.size()), '\0');
      written[view] = document["bufferViews"].size();
      document["bufferViews"].push_back(json::object(
          {{"buffer", 0}, {"byteOffset", binary.size()}, {"byteLength", picture.size()}}));
      binary.append(picture);
    }
    if (const auto found = written.find(view); found != written.end()) {
      image["bufferView"] = found->second;
    } else {
      image.erase("bufferView");
    }
    document["images"].push_back(std::move(image));
  }
}

void GlbMaterials::AddTo(json& document, std::string& binary) && {
  if (materials_.empty()) return;
  const json& root = source_->root();
  AddImages(document, binary);
  for (const char* name : {"textures", "samplers"}) {
    if (const json& array = GlbArray(root, name); !array.empty()) document[name] = array;
  }
  document["materials"] = std::exchange(materials_, json::array());
  std::set<std::string, std::less<>> keys;
  AddKeys(document["materials"], &keys);
  AddKeys(GlbArray(document, "textures"), &keys);
  for (const char* list : {"extensionsUsed", "extensionsRequired"}) {
    std::set<std::string_view> listed;
    for (const json& name : GlbArray(root, list)) {
      if (!name.is_string()) continue;
      const auto& text = name.get_ref<const std::string&>();
      if (keys.contains(text) && listed.insert(text).second) document[list].push_back(text);
    }
  }
}

uint64_t GlbMaterials::MostBytes(std::string_view source) {
  // The source's tree, a copy of its materials and one in the file's tree; text when it is put together.
  return 3 * GlbDocument::TreeBytes(source) + 2 * MostTextBytes(source) + source.size();
}

}  // namespace latticed
