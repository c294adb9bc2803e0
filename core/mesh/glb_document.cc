// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

#include "core/mesh/glb_document.h"

#include <algorithm>
#include <array>
#include <limits>
#include <string>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/mesh/glb_layout.h"
#include "core/mesh/little_endian.h"
#include "core/mesh/mesh_reading.h"
#include "fmt/format.h"

namespace latticed {
namespace {

using nlohmann::json;

const json kNull;
// Of JSON's tree whose vector has just doubled: 47 for "[{},{},…", with what its destructor allocates, which must not fail.
constexpr uint64_t kTreeBytesPerByte = 56;
constexpr int kMaxNesting = 64;  // glTF itself needs about 8

struct Chunks {
  std::string_view text;
  std::string_view binary;
};

absl::StatusOr<std::string_view> TakeChunk(std::string_view bytes, size_t offset, uint32_t type) {
  const std::string where = fmt::format("byte {}", offset);
  if (bytes.size() - offset < glb::kChunkHeaderBytes)
    return MalformedGlb(where, "a chunk is cut off");
  const auto length = LoadLittleEndian<uint32_t>(&bytes[offset]);
  if (LoadLittleEndian<uint32_t>(&bytes[offset + 4]) != type) {
    return MalformedGlb(where, "a chunk of another type than JSON first, then BIN");
  }
  offset += glb::kChunkHeaderBytes;
  if (length > bytes.size() - offset) {
    return MalformedGlb(
        where, fmt::format("a chunk of {} bytes, {} are left", length, bytes.size() - offset));
  }
  return bytes.substr(offset, length);
}

absl::StatusOr<Chunks> SplitChunks(std::string_view bytes) {
  if (bytes.size() < glb::kHeaderBytes) return MalformedGlb("byte 0", "the header is cut off");
  if (LoadLittleEndian<uint32_t>(&bytes[0]) != glb::kMagic) {
    return MalformedGlb("byte 0", "it does not start with 'glTF'");
  }
  const auto version = LoadLittleEndian<uint32_t>(&bytes[4]);
  if (version != glb::kVersion) {
    return MalformedGlb("byte 4", fmt::format("version {}; only 2 is known", version));
  }
  const auto length = LoadLittleEndian<uint32_t>(&bytes[8]);
  if (length > bytes.size() || length < glb::kHeaderBytes) {
    return MalformedGlb(
        "byte 8", fmt::format("{} bytes are announced, the file has {}", length, bytes.size()));
  }
  bytes = bytes.substr(0, length);
  Chunks chunks;
  LATTICED_ASSIGN_OR_RETURN(chunks.text, TakeChunk(bytes, glb::kHeaderBytes, glb::kJsonChunk));
  const size_t next = glb::kHeaderBytes + glb::kChunkHeaderBytes + glb::Aligned(chunks.text.size());
  if (next >= bytes.size()) return chunks;
  LATTICED_ASSIGN_OR_RETURN(chunks.binary, TakeChunk(bytes, next, glb::kBinaryChunk));
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

// An unknown extension may store geometry in another way, which would then be read wrongly.
absl::Status CheckExtensions(const json& document) {
  constexpr std::string_view kHarmless[] = {"KHR_mesh_quantization", "KHR_texture_transform",
                                            "KHR_texture_basisu",    "KHR_lights_punctual",
                                            "EXT_texture_webp",      "EXT_texture_avif"};
  for (const json& name : GlbArray(document, "extensionsRequired")) {
    if (!name.is_string()) continue;
    const auto& text = name.get_ref<const std::string&>();
    if (text.starts_with("KHR_materials_") || std::ranges::count(kHarmless, text) > 0) continue;
    return MalformedGlb("extensionsRequired",
                        fmt::format("the extension {} is not supported", Quoted(text)));
  }
  return absl::OkStatus();
}

absl::Status CheckBuffers(const json& document, std::string_view binary) {
  const json& buffers = GlbArray(document, "buffers");
  if (buffers.size() > 1) {
    return MalformedGlb("buffers[1]", "only the BIN chunk is read, no further buffer");
  }
  for (const json& buffer : buffers) {
    if (!buffer.is_object()) return MalformedGlb("buffers[0]", "not an object");
    if (buffer.contains("uri")) return MalformedGlb("buffers[0].uri", "only the BIN chunk is read");
    const auto length = buffer.find("byteLength");
    if (length == buffer.end() || !length->is_number_unsigned() || length->get<uint64_t>() == 0 ||
        length->get<uint64_t>() > binary.size()) {
      return MalformedGlb(
          "buffers[0].byteLength",
          fmt::format("not within the BIN chunk, which has {} bytes", binary.size()));
    }
  }
  return absl::OkStatus();
}

template <typename T>
double LoadComponent(const char* bytes) {
  return static_cast<double>(LoadLittleEndian<T>(bytes));
}

constexpr std::array<GlbComponentType, 6> kComponentTypes = {{
    {glb::kByte, 1, 127, LoadComponent<int8_t>},
    {glb::kUnsignedByte, 1, 255, LoadComponent<uint8_t>},
    {glb::kShort, 2, 32'767, LoadComponent<int16_t>},
    {glb::kUnsignedShort, 2, 65'535, LoadComponent<uint16_t>},
    {glb::kUnsignedInt, 4, 0, LoadComponent<uint32_t>},
    {glb::kFloat, 4, 0, LoadComponent<float>},
}};

int ComponentsOf(std::string_view type) {
  constexpr std::array<std::string_view, 4> kTypes = {"SCALAR", "VEC2", "VEC3", "VEC4"};
  const auto found = std::ranges::find(kTypes, type);
  return found == kTypes.end() ? 0 : static_cast<int>(found - kTypes.begin()) + 1;
}

// A count, or an offset in bytes. For a value that is neither, returns a number larger than any file.
uint64_t Size(const json& object, const char* key) {
  const json& value = GlbMember(object, key);
  if (value.is_null()) return 0;
  return value.is_number_unsigned() ? value.get<uint64_t>() : std::numeric_limits<uint64_t>::max();
}

int64_t IndexFrom(const json& value) {
  return value.is_number_integer() ? value.get<int64_t>() : kGlbNoIndex - 1;
}

}  // namespace

absl::Status MalformedGlb(std::string_view where, std::string_view problem) {
  return error::MalformedFile("GLB", where, problem);
}

const json& GlbMember(const json& object, const char* key) {
  const auto it = object.find(key);
  return it == object.end() ? kNull : *it;
}

const json& GlbArray(const json& object, const char* key) {
  const json& member = GlbMember(object, key);
  return member.is_array() ? member : kNull;
}

int64_t GlbIndex(const json& object, const char* key) {
  const json& value = GlbMember(object, key);
  return value.is_null() ? kGlbNoIndex : IndexFrom(value);
}

std::vector<int64_t> GlbIndices(const json& object, const char* key) {
  std::vector<int64_t> indices;
  for (const json& value : GlbArray(object, key)) indices.push_back(IndexFrom(value));
  return indices;
}

std::vector<double> GlbNumbers(const json& object, const char* key) {
  std::vector<double> numbers;
  for (const json& value : GlbArray(object, key)) {
    if (value.is_number()) numbers.push_back(value.get<double>());
  }
  return numbers;
}

std::string GlbString(const json& object, const char* key) {
  const json& value = GlbMember(object, key);
  return value.is_string() ? value.get<std::string>() : "";
}

double GlbAccessor::Component(size_t i, size_t c) const {
  const double value = type->load(data + i * stride + c * type->bytes);
  return normalized ? std::max(value / type->largest, -1.0) : value;
}

size_t GlbAccessor::Index(size_t i) const {
  return static_cast<size_t>(type->load(data + i * stride));
}

absl::StatusOr<GlbDocument> GlbDocument::Parse(std::string_view bytes, ReadingMemory* memory) {
  LATTICED_ASSIGN_OR_RETURN(Chunks chunks, SplitChunks(bytes));
  if (NestsTooDeep(chunks.text)) {
    return MalformedGlb("the JSON chunk", fmt::format("nested deeper than {}", kMaxNesting));
  }
  const uint64_t tree_bytes = kTreeBytesPerByte * chunks.text.size();
  if (memory != nullptr) LATTICED_RETURN_IF_ERROR(memory->Hold(tree_bytes));
  json document = json::parse(chunks.text, nullptr, /*allow_exceptions=*/false);
  if (!document.is_object()) return MalformedGlb("the JSON chunk", "not a JSON object");
  LATTICED_RETURN_IF_ERROR(CheckExtensions(document));
  LATTICED_RETURN_IF_ERROR(CheckBuffers(document, chunks.binary));
  const json& buffers = GlbArray(document, "buffers");
  const size_t size = buffers.empty() ? 0 : Size(buffers[0], "byteLength");
  return GlbDocument(std::move(document), tree_bytes, chunks.binary.substr(0, size));
}

uint64_t GlbDocument::TreeBytes(std::string_view file) {
  return kTreeBytesPerByte * JsonBytes(file);
}

uint64_t GlbDocument::JsonBytes(std::string_view file) {
  const auto chunks = SplitChunks(file);
  return chunks.ok() ? chunks->text.size() : 0;
}

std::string_view GlbDocument::BufferView(int64_t index) const {
  const json& views = GlbArray(root_, "bufferViews");
  if (index < 0 || static_cast<size_t>(index) >= views.size()) return {};
  const json& view = views[static_cast<size_t>(index)];
  const uint64_t offset = Size(view, "byteOffset"), bytes = Size(view, "byteLength");
  const bool fits = offset <= buffer_.size() && bytes <= buffer_.size() - offset;
  return fits && GlbIndex(view, "buffer") == 0 ? buffer_.substr(offset, bytes) : std::string_view();
}

absl::StatusOr<GlbAccessor> GlbDocument::Open(int64_t index, int components) const {
  const std::string where = fmt::format("accessors[{}]", index);
  const json& accessors = GlbArray(root_, "accessors");
  if (index < 0 || static_cast<size_t>(index) >= accessors.size()) {
    return MalformedGlb(where, fmt::format("there are {} accessors", accessors.size()));
  }
  const json& accessor = accessors[static_cast<size_t>(index)];
  if (!GlbMember(accessor, "sparse").is_null())
    return MalformedGlb(where, "sparse accessors are not supported");
  const json& views = GlbArray(root_, "bufferViews");
  const int64_t view_index = GlbIndex(accessor, "bufferView");
  if (view_index < 0 || static_cast<size_t>(view_index) >= views.size()) {
    return MalformedGlb(where, "it has no buffer view, or one that does not exist");
  }
  const json& view = views[static_cast<size_t>(view_index)];
  if (GlbIndex(view, "buffer") != 0) return MalformedGlb(where, "its buffer does not exist");
  const int64_t number = GlbIndex(accessor, "componentType");
  const auto type = std::ranges::find(kComponentTypes, number, &GlbComponentType::number);
  if (type == kComponentTypes.end()) {
    return MalformedGlb(where, fmt::format("component type {}", number));
  }
  if (ComponentsOf(GlbString(accessor, "type")) != components) {
    return MalformedGlb(where, fmt::format("{} components are needed", components));
  }

  const uint64_t view_offset = Size(view, "byteOffset"), view_bytes = Size(view, "byteLength");
  if (view_offset > buffer_.size() || view_bytes > buffer_.size() - view_offset) {
    return MalformedGlb(where, "its buffer view leaves the buffer");
  }
  const size_t element = type->bytes * static_cast<size_t>(components);
  const uint64_t given_stride = Size(view, "byteStride"), count = Size(accessor, "count");
  const uint64_t stride = given_stride == 0 ? element : given_stride;
  const uint64_t offset = Size(accessor, "byteOffset");
  const uint64_t room = view_bytes < offset ? 0 : view_bytes - offset;
  const bool fits =
      stride >= element && count > 0 && room >= element && count - 1 <= (room - element) / stride;
  if (!fits) {
    return MalformedGlb(
        where, fmt::format("{} elements of {} bytes do not fit into {}", count, element, room));
  }
  return GlbAccessor{
      .data = buffer_.data() + view_offset + offset,
      .count = count,
      .stride = stride,
      .type = &*type,
      .normalized = type->largest > 0 && GlbMember(accessor, "normalized") == json(true)};
}

absl::StatusOr<GlbAccessor> GlbDocument::OpenIndices(int64_t index) const {
  absl::StatusOr<GlbAccessor> accessor = Open(index, 1);
  if (!accessor.ok()) return accessor;
  const int type = accessor->type->number;
  if (type == glb::kUnsignedByte || type == glb::kUnsignedShort || type == glb::kUnsignedInt) {
    return accessor;
  }
  return MalformedGlb(fmt::format("accessors[{}]", index), "indices are not unsigned integers");
}

}  // namespace latticed
