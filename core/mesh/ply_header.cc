// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

#include "core/mesh/ply_header.h"

#include <algorithm>
#include <initializer_list>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/mesh/little_endian.h"
#include "core/mesh/mesh_reading.h"
#include "core/mesh/reading_memory.h"
#include "fmt/format.h"

namespace latticed {
namespace {

// Real files have a handful; a record's size must stay a small number.
constexpr size_t kMaxElements = 64;
constexpr size_t kMaxPropertiesPerElement = 1'024;

template <typename T>
double LoadValue(const char* bytes) {
  return static_cast<double>(LoadLittleEndian<T>(bytes));
}

constexpr PlyType kTypes[] = {
    {{"char", "int8"}, 1, true, LoadValue<int8_t>},
    {{"uchar", "uint8"}, 1, true, LoadValue<uint8_t>},
    {{"short", "int16"}, 2, true, LoadValue<int16_t>},
    {{"ushort", "uint16"}, 2, true, LoadValue<uint16_t>},
    {{"int", "int32"}, 4, true, LoadValue<int32_t>},
    {{"uint", "uint32"}, 4, true, LoadValue<uint32_t>},
    {{"float", "float32"}, 4, false, LoadValue<float>},
    {{"double", "float64"}, 8, false, LoadValue<double>},
};

class HeaderReader {
 public:
  HeaderReader(std::string_view bytes, ReadingMemory* memory)
      : rest_(bytes), bytes_(bytes.size()), memory_(memory) {}

  absl::StatusOr<PlyHeader> Read() {
    std::string_view line = TakeLine();
    if (TakeWord(&line) != "ply") return Malformed("the first line is not 'ply'");
    while (!ended_) {
      if (rest_.empty()) return Malformed("the file ends before end_header");
      LATTICED_RETURN_IF_ERROR(ReadLine(TakeLine()));
    }
    if (!has_format_) return Malformed("the header has no format line");
    header_.body_offset = bytes_ - rest_.size();
    return std::move(header_);
  }

 private:
  absl::Status Malformed(std::string_view problem) const {
    return error::MalformedFile("PLY", fmt::format("line {}", line_), problem);
  }

  // The body begins right after the end of end_header.
  std::string_view TakeLine() {
    ++line_;
    return TakeTextLine(&rest_);
  }

  // Called before an element or a property is kept. Half of what vectors take while they grow is given back.
  absl::Status Keep(size_t object_bytes, std::string_view name) {
    constexpr uint64_t kBlockBytes = 32;  // malloc's own, and the end of the string
    header_.memory_bytes += 3 * object_bytes + kBlockBytes + name.size();
    return memory_ == nullptr ? absl::OkStatus() : memory_->Hold(header_.memory_bytes);
  }

  absl::Status ReadLine(std::string_view line) {
    const std::string_view keyword = TakeWord(&line);
    if (keyword == "format") return ReadFormat(line);
    if (keyword == "element") return ReadElement(line);
    if (keyword == "property") return ReadProperty(line);
    if (keyword == "end_header") {
      ended_ = true;
      return absl::OkStatus();
    }
    if (keyword.empty() || keyword == "comment" || keyword == "obj_info") return absl::OkStatus();
    return Malformed(fmt::format("{} is no header keyword", Quoted(keyword)));
  }

  absl::Status ReadFormat(std::string_view line) {
    const std::string_view name = TakeWord(&line);
    const std::string_view version = TakeWord(&line);
    if (name == "ascii") {
      header_.encoding = PlyEncoding::kAscii;
    } else if (name == "binary_little_endian") {
      header_.encoding = PlyEncoding::kLittleEndian;
    } else if (name == "binary_big_endian") {
      header_.encoding = PlyEncoding::kBigEndian;
    } else {
      return Malformed(
          fmt::format("{} is no format; known are ascii, binary_little_endian, binary_big_endian",
                      Quoted(name)));
    }
    if (version != "1.0") return Malformed(fmt::format("version {} is not 1.0", Quoted(version)));
    has_format_ = true;
    return absl::OkStatus();
  }

  absl::Status ReadElement(std::string_view line) {
    PlyElement element;
    const std::string_view name = TakeWord(&line);
    LATTICED_RETURN_IF_ERROR(Keep(sizeof(PlyElement), name));
    element.name = std::string(name);
    const std::string_view count = TakeWord(&line);
    int64_t value = 0;
    if (element.name.empty()) return Malformed("an element has no name");
    if (!ParseInteger(count, &value)) return Malformed(NumberProblem(count));
    if (value < 0) return Malformed(fmt::format("{} elements", value));
    if (header_.elements.size() >= kMaxElements) {
      return Malformed(fmt::format("more than {} elements", kMaxElements));
    }
    element.count = static_cast<uint64_t>(value);
    header_.elements.push_back(std::move(element));
    return absl::OkStatus();
  }

  absl::Status ReadProperty(std::string_view line) {
    if (header_.elements.empty()) return Malformed("a property before any element");
    std::vector<PlyProperty>& properties = header_.elements.back().properties;
    if (properties.size() >= kMaxPropertiesPerElement) {
      return Malformed(fmt::format("more than {} properties", kMaxPropertiesPerElement));
    }
    PlyProperty property;
    std::string_view type = TakeWord(&line);
    if (type == "list") {
      LATTICED_RETURN_IF_ERROR(ReadType(TakeWord(&line), &property.count_type));
      if (!property.count_type->is_integer) return Malformed("a list's length is no integer");
      type = TakeWord(&line);
    }
    LATTICED_RETURN_IF_ERROR(ReadType(type, &property.type));
    const std::string_view name = TakeWord(&line);
    LATTICED_RETURN_IF_ERROR(Keep(sizeof(PlyProperty), name));
    property.name = std::string(name);
    if (property.name.empty()) return Malformed("a property has no name");
    properties.push_back(std::move(property));
    return absl::OkStatus();
  }

  absl::Status ReadType(std::string_view word, const PlyType** type) const {
    for (const PlyType& known : kTypes) {
      if (std::ranges::count(known.names, word) == 0) continue;
      *type = &known;
      return absl::OkStatus();
    }
    return Malformed(fmt::format("{} is no type", Quoted(word)));
  }

  PlyHeader header_;
  std::string_view rest_;
  const size_t bytes_;
  ReadingMemory* const memory_;
  size_t line_ = 0;
  bool has_format_ = false, ended_ = false;
};

}  // namespace

size_t PlyElement::MinBinaryBytes() const {
  size_t bytes = 0;
  for (const PlyProperty& p : properties) bytes += (p.is_list() ? p.count_type : p.type)->bytes;
  return bytes;
}

int PlyElement::FindProperty(std::initializer_list<std::string_view> names, bool is_list) const {
  for (size_t i = 0; i < properties.size(); ++i) {
    if (properties[i].is_list() != is_list) continue;
    for (std::string_view name : names) {
      if (properties[i].name == name) return static_cast<int>(i);
    }
  }
  return -1;
}

const PlyElement* PlyHeader::FindElement(std::string_view name) const {
  for (const PlyElement& element : elements) {
    if (element.name == name) return &element;
  }
  return nullptr;
}

absl::StatusOr<PlyHeader> ReadPlyHeader(std::string_view bytes, ReadingMemory* memory) {
  return HeaderReader(bytes, memory).Read();
}

}  // namespace latticed
