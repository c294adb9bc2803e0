// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

#include "core/mesh/glb_document.h"

#include <algorithm>
#include <exception>
#include <fstream>  // tinygltf's writer names it even without its file system
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/mesh/glb_layout.h"
#include "core/mesh/little_endian.h"
#include "core/mesh/mesh_reading.h"
#include "fmt/format.h"

// The only file that makes tinygltf's code.
#define TINYGLTF_IMPLEMENTATION
#include <tiny_gltf.h>

namespace latticed {
namespace {

using nlohmann::json;

constexpr int kMaxNesting = 64;  // glTF itself needs about 8

absl::Status Malformed(std::string_view where, std::string_view problem) {
  return error::MalformedFile("GLB", where, problem);
}

struct Chunks {
  std::string_view text;
  std::string_view binary;
};

absl::StatusOr<std::string_view> TakeChunk(std::string_view bytes, size_t offset, uint32_t type) {
  const std::string where = fmt::format("byte {}", offset);
  if (bytes.size() - offset < glb::kChunkHeaderBytes) return Malformed(where, "a chunk is cut off");
  const auto length = LoadLittleEndian<uint32_t>(&bytes[offset]);
  if (LoadLittleEndian<uint32_t>(&bytes[offset + 4]) != type) {
    return Malformed(where, "a chunk of another type than JSON first, then BIN");
  }
  offset += glb::kChunkHeaderBytes;
  if (length > bytes.size() - offset) {
    return Malformed(
        where, fmt::format("a chunk of {} bytes, {} are left", length, bytes.size() - offset));
  }
  return bytes.substr(offset, length);
}

absl::StatusOr<Chunks> SplitChunks(std::string_view bytes) {
  if (bytes.size() < glb::kHeaderBytes) return Malformed("byte 0", "the header is cut off");
  if (LoadLittleEndian<uint32_t>(&bytes[0]) != glb::kMagic) {
    return Malformed("byte 0", "it does not start with 'glTF'");
  }
  const auto version = LoadLittleEndian<uint32_t>(&bytes[4]);
  if (version != glb::kVersion) {
    return Malformed("byte 4", fmt::format("version {}; only 2 is known", version));
  }
  const auto length = LoadLittleEndian<uint32_t>(&bytes[8]);
  if (length > bytes.size() || length < glb::kHeaderBytes) {
    return Malformed("byte 8",
                     fmt::format("{} bytes are announced, the file has {}", length, bytes.size()));
  }
  bytes = bytes.substr(0, length);
  Chunks chunks;
  LATTICED_ASSIGN_OR_RETURN(std::string_view text,
                            TakeChunk(bytes, glb::kHeaderBytes, glb::kJsonChunk));
  chunks.text = text;
  const size_t next = glb::kHeaderBytes + glb::kChunkHeaderBytes + glb::Aligned(text.size());
  if (next >= bytes.size()) return chunks;
  LATTICED_ASSIGN_OR_RETURN(std::string_view binary, TakeChunk(bytes, next, glb::kBinaryChunk));
  chunks.binary = binary;
  return chunks;
}

bool NestsTooDeep(std::string_view text) {
  int depth = 0;
  bool in_string = false;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      if (c == '\\') ++i;
      if (c == '"') in_string = false;
    } else if (c == '"') {
      in_string = true;
    } else if (c == '{' || c == '[') {
      if (++depth > kMaxNesting) return true;
    } else if (c == '}' || c == ']') {
      --depth;
    }
  }
  return false;
}

// Objects of the array `name`, each with the given keys only.
json Reduced(const json& document, const char* name, std::initializer_list<const char*> keys) {
  json reduced = json::array();
  const auto array = document.find(name);
  if (array == document.end() || !array->is_array()) return reduced;
  for (const json& element : *array) {
    json kept = json::object();
    for (const char* key : keys) {
      if (!element.is_object()) break;
      if (const auto it = element.find(key); it != element.end()) kept[key] = *it;
    }
    reduced.push_back(std::move(kept));
  }
  return reduced;
}

absl::Status CheckExtensions(const json& document) {
  // Those that change how the geometry of this reader is stored would be read wrongly without
  // notice.
  constexpr std::string_view kHarmless[] = {"KHR_mesh_quantization", "KHR_texture_transform",
                                            "KHR_texture_basisu",    "KHR_lights_punctual",
                                            "EXT_texture_webp",      "EXT_texture_avif"};
  const auto required = document.find("extensionsRequired");
  if (required == document.end() || !required->is_array()) return absl::OkStatus();
  for (const json& name : *required) {
    if (!name.is_string()) continue;
    const auto& text = name.get_ref<const std::string&>();
    const bool harmless =
        text.compare(0, 14, "KHR_materials_") == 0 ||
        std::find(std::begin(kHarmless), std::end(kHarmless), text) != std::end(kHarmless);
    if (harmless) continue;
    return Malformed("extensionsRequired",
                     fmt::format("the extension {} is not supported", Quoted(text)));
  }
  return absl::OkStatus();
}

absl::Status CheckBuffers(const json& document, std::string_view binary) {
  const auto buffers = document.find("buffers");
  if (buffers == document.end() || !buffers->is_array()) return absl::OkStatus();
  if (buffers->size() > 1) {
    return Malformed("buffers[1]", "only the BIN chunk is read, no further buffer");
  }
  for (const json& buffer : *buffers) {
    if (!buffer.is_object()) return Malformed("buffers[0]", "not an object");
    if (buffer.contains("uri")) return Malformed("buffers[0].uri", "only the BIN chunk is read");
    const auto length = buffer.find("byteLength");
    if (length == buffer.end() || !length->is_number_unsigned() || length->get<uint64_t>() == 0 ||
        length->get<uint64_t>() > binary.size()) {
      return Malformed("buffers[0].byteLength",
                       fmt::format("not within the BIN chunk, which has {} bytes", binary.size()));
    }
  }
  return absl::OkStatus();
}

json ReducedDocument(const json& document) {
  json reduced = {{"asset", {{"version", "2.0"}}}};
  if (document.contains("scene")) reduced["scene"] = document["scene"];
  reduced["scenes"] = Reduced(document, "scenes", {"nodes"});
  reduced["nodes"] = Reduced(document, "nodes",
                             {"mesh", "children", "matrix", "translation", "rotation", "scale"});
  reduced["meshes"] = Reduced(document, "meshes", {"name", "primitives"});
  for (json& mesh : reduced["meshes"]) {
    mesh["primitives"] = Reduced(mesh, "primitives", {"attributes", "indices", "material", "mode"});
  }
  reduced["materials"] = Reduced(document, "materials", {"name"});
  reduced["accessors"] = Reduced(
      document, "accessors",
      {"bufferView", "byteOffset", "componentType", "count", "type", "normalized", "sparse"});
  reduced["bufferViews"] =
      Reduced(document, "bufferViews", {"buffer", "byteOffset", "byteLength", "byteStride"});
  reduced["buffers"] = Reduced(document, "buffers", {"byteLength"});
  return reduced;
}

std::string PackGlb(const std::string& text, std::string_view binary) {
  std::string glb;
  const size_t text_bytes = glb::Aligned(text.size()), binary_bytes = glb::Aligned(binary.size());
  const size_t chunk = binary.empty() ? 0 : glb::kChunkHeaderBytes + binary_bytes;
  const size_t total = glb::kHeaderBytes + glb::kChunkHeaderBytes + text_bytes + chunk;
  glb.reserve(total);
  for (size_t word :
       {size_t{glb::kMagic}, size_t{glb::kVersion}, total, text_bytes, size_t{glb::kJsonChunk}}) {
    AppendLittleEndian(static_cast<uint32_t>(word), &glb);
  }
  glb.append(text).append(text_bytes - text.size(), ' ');
  if (binary.empty()) return glb;
  AppendLittleEndian(static_cast<uint32_t>(binary_bytes), &glb);
  AppendLittleEndian(glb::kBinaryChunk, &glb);
  return glb.append(binary).append(binary_bytes - binary.size(), '\0');
}

size_t ComponentBytes(int component_type) {
  switch (component_type) {
    case glb::kByte:
    case glb::kUnsignedByte:
      return 1;
    case glb::kShort:
    case glb::kUnsignedShort:
      return 2;
    case glb::kUnsignedInt:
    case glb::kFloat:
      return 4;
    default:
      return 0;
  }
}

int ComponentsOf(int type) {
  switch (type) {
    case TINYGLTF_TYPE_SCALAR:
      return 1;
    case TINYGLTF_TYPE_VEC2:
      return 2;
    case TINYGLTF_TYPE_VEC3:
      return 3;
    case TINYGLTF_TYPE_VEC4:
      return 4;
    default:
      return 0;
  }
}

}  // namespace

double GlbAccessor::Component(size_t i, int c) const {
  const auto* element = reinterpret_cast<const char*>(data + i * stride);
  const auto scaled = [this](double value, double largest) {
    return normalized ? std::max(value / largest, -1.0) : value;
  };
  switch (component_type) {
    case glb::kByte:
      return scaled(LoadLittleEndian<int8_t>(element + c), 127);
    case glb::kUnsignedByte:
      return scaled(LoadLittleEndian<uint8_t>(element + c), 255);
    case glb::kShort:
      return scaled(LoadLittleEndian<int16_t>(element + 2 * c), 32767);
    case glb::kUnsignedShort:
      return scaled(LoadLittleEndian<uint16_t>(element + 2 * c), 65535);
    case glb::kUnsignedInt:
      return LoadLittleEndian<uint32_t>(element + 4 * c);
    default:
      return double{LoadLittleEndian<float>(element + 4 * c)};
  }
}

size_t GlbAccessor::Index(size_t i) const {
  const auto* element = reinterpret_cast<const char*>(data + i * stride);
  switch (component_type) {
    case glb::kUnsignedByte:
      return LoadLittleEndian<uint8_t>(element);
    case glb::kUnsignedShort:
      return LoadLittleEndian<uint16_t>(element);
    default:
      return LoadLittleEndian<uint32_t>(element);
  }
}

GlbDocument::GlbDocument() : model_(std::make_unique<tinygltf::Model>()) {}
GlbDocument::GlbDocument(GlbDocument&&) noexcept = default;
GlbDocument& GlbDocument::operator=(GlbDocument&&) noexcept = default;
GlbDocument::~GlbDocument() = default;

absl::StatusOr<GlbDocument> GlbDocument::Parse(std::string_view bytes) {
  LATTICED_ASSIGN_OR_RETURN(Chunks chunks, SplitChunks(bytes));
  if (NestsTooDeep(chunks.text)) {
    return Malformed("the JSON chunk", fmt::format("nested deeper than {}", kMaxNesting));
  }
  const json document = json::parse(chunks.text, nullptr, /*allow_exceptions=*/false);
  if (!document.is_object()) return Malformed("the JSON chunk", "not a JSON object");
  LATTICED_RETURN_IF_ERROR(CheckExtensions(document));
  LATTICED_RETURN_IF_ERROR(CheckBuffers(document, chunks.binary));

  GlbDocument result;
  try {  // neither nlohmann's accessors nor tinygltf promise not to throw on wrong types
    const std::string glb =
        PackGlb(ReducedDocument(document).dump(-1, ' ', false, json::error_handler_t::replace),
                chunks.binary);
    tinygltf::TinyGLTF loader;
    std::string problem, warning;
    const bool loaded = loader.LoadBinaryFromMemory(
        result.model_.get(), &problem, &warning, reinterpret_cast<const unsigned char*>(glb.data()),
        static_cast<unsigned>(glb.size()));
    if (!loaded) return Malformed("the JSON chunk", problem.substr(0, problem.find('\n')));
  } catch (const std::exception& e) {
    return Malformed("the JSON chunk", e.what());
  }
  return result;
}

absl::StatusOr<GlbAccessor> GlbDocument::Open(int index, int components) const {
  const std::string where = fmt::format("accessors[{}]", index);
  if (index < 0 || static_cast<size_t>(index) >= model_->accessors.size()) {
    return Malformed(where, fmt::format("there are {} accessors", model_->accessors.size()));
  }
  const tinygltf::Accessor& accessor = model_->accessors[static_cast<size_t>(index)];
  if (accessor.sparse.isSparse) return Malformed(where, "sparse accessors are not supported");
  if (accessor.bufferView < 0 ||
      static_cast<size_t>(accessor.bufferView) >= model_->bufferViews.size()) {
    return Malformed(where, "it has no buffer view, or one that does not exist");
  }
  const tinygltf::BufferView& view = model_->bufferViews[static_cast<size_t>(accessor.bufferView)];
  if (view.buffer < 0 || static_cast<size_t>(view.buffer) >= model_->buffers.size()) {
    return Malformed(where, "its buffer does not exist");
  }
  const size_t component_bytes = ComponentBytes(accessor.componentType);
  if (component_bytes == 0) {
    return Malformed(where, fmt::format("component type {}", accessor.componentType));
  }
  if (ComponentsOf(accessor.type) != components) {
    return Malformed(where, fmt::format("{} components are needed", components));
  }
  const std::vector<unsigned char>& buffer = model_->buffers[static_cast<size_t>(view.buffer)].data;
  const size_t element = component_bytes * static_cast<size_t>(components);
  const size_t stride = view.byteStride == 0 ? element : view.byteStride;
  if (view.byteOffset > buffer.size() || view.byteLength > buffer.size() - view.byteOffset) {
    return Malformed(where, "its buffer view leaves the buffer");
  }
  const size_t room =
      view.byteLength < accessor.byteOffset ? 0 : view.byteLength - accessor.byteOffset;
  const bool fits = stride >= element && accessor.count > 0 && room >= element &&
                    accessor.count - 1 <= (room - element) / stride;
  if (!fits) {
    return Malformed(where, fmt::format("{} elements of {} bytes do not fit into {}",
                                        accessor.count, element, room));
  }
  return GlbAccessor{.data = buffer.data() + view.byteOffset + accessor.byteOffset,
                     .count = accessor.count,
                     .stride = stride,
                     .component_type = accessor.componentType,
                     .components = components,
                     .normalized = accessor.normalized};
}

absl::StatusOr<GlbAccessor> GlbDocument::OpenIndices(int index) const {
  absl::StatusOr<GlbAccessor> accessor = Open(index, 1);
  if (!accessor.ok()) return accessor;
  const int type = accessor->component_type;
  if (type == glb::kUnsignedByte || type == glb::kUnsignedShort || type == glb::kUnsignedInt) {
    return accessor;
  }
  return Malformed(fmt::format("accessors[{}]", index), "indices are not unsigned integers");
}

}  // namespace latticed
