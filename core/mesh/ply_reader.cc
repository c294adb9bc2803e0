// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Stanford PLY: ascii, binary little endian, binary big endian.
//
// Reads, of the element `vertex`: x y z, nx ny nz, weight, and a pair s t, u v or texture_u texture_v; of `face`: the list
// vertex_indices or vertex_index; of `tristrips`: the list vertex_indices, whose strips end with -1. Triangles of a
// strip that have a repeated vertex only join strips and are left out. Other elements and properties are skipped, lists
// too. Texture coordinates have their origin at the lower left.
//
// Errors   kInvalidArgument, reason MALFORMED_FILE, naming line (header, ascii) or byte
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "core/mesh/little_endian.h"
#include "core/mesh/mesh_io.h"
#include "core/mesh/mesh_reading.h"
#include "core/mesh/ply_header.h"
#include "core/mesh/reading_memory.h"
#include "fmt/format.h"

namespace latticed {
namespace {

// Values of the body in their order, as doubles: every type of PLY fits.
class PlyBody {
 public:
  PlyBody(std::string_view bytes, const PlyHeader& header)
      : bytes_(bytes), offset_(header.body_offset), encoding_(header.encoding) {}

  size_t bytes_left() const { return bytes_.size() - offset_; }
  bool is_ascii() const { return encoding_ == PlyEncoding::kAscii; }

  absl::Status Malformed(std::string_view problem) const {
    return error::MalformedFile(
        "PLY", is_ascii() ? LineAt(bytes_, offset_) : fmt::format("byte {}", offset_), problem);
  }

  // The value may be NaN or infinite in a binary file; callers check it.
  absl::Status Read(const PlyType& type, double* value) {
    if (is_ascii()) return ReadAscii(type, value);
    const size_t size = type.bytes;
    if (bytes_left() < size) return Malformed("the file ends too early");
    char number[sizeof(double)];
    std::copy_n(&bytes_[offset_], size, number);
    if (encoding_ == PlyEncoding::kBigEndian) std::reverse(number, number + size);
    *value = type.load(number);
    offset_ += size;
    return absl::OkStatus();
  }

  absl::Status Skip(const PlyType& type, uint64_t count) {
    if (is_ascii()) {
      for (uint64_t i = 0; i < count; ++i) {
        if (TakeAsciiWord().empty()) return Malformed("the file ends too early");
      }
      return absl::OkStatus();
    }
    if (bytes_left() / type.bytes < count) return Malformed("the file ends too early");
    offset_ += type.bytes * count;
    return absl::OkStatus();
  }

  absl::Status ReadListLength(const PlyProperty& list, uint64_t* length) {
    double value = 0;
    LATTICED_RETURN_IF_ERROR(Read(*list.count_type, &value));
    constexpr double kLongest = 4294967295.0;  // of the widest count type
    if (value < 0 || value > kLongest)
      return Malformed(fmt::format("a list has the length {}", value));
    *length = static_cast<uint64_t>(value);
    const size_t least_bytes = is_ascii() ? 1 : list.type->bytes;
    if (*length > bytes_left() / least_bytes) {
      return Malformed(fmt::format("a list of {} values in {} bytes", *length, bytes_left()));
    }
    return absl::OkStatus();
  }

 private:
  std::string_view TakeAsciiWord() {
    std::string_view rest = bytes_.substr(offset_);
    const std::string_view word = TakeWord(&rest);
    offset_ = bytes_.size() - rest.size();
    return word;
  }

  absl::Status ReadAscii(const PlyType& type, double* value) {
    const std::string_view word = TakeAsciiWord();
    if (word.empty()) return Malformed("the file ends too early");
    if (!ParseNumber(word, value)) return Malformed(NumberProblem(word));
    if (type.is_integer && *value != std::floor(*value)) {
      return Malformed(fmt::format("{} is not an integer", Quoted(word)));
    }
    return absl::OkStatus();
  }

  const std::string_view bytes_;
  size_t offset_;
  const PlyEncoding encoding_;
};

class PlyReader {
 public:
  PlyReader(std::string_view bytes, PlyHeader header, ReadingMemory* memory)
      : header_(std::move(header)), body_(bytes, header_), growth_(memory, &mesh_) {
    growth_.NoteNames(header_.memory_bytes);
  }

  absl::StatusOr<PolygonMesh> Read() {
    const PlyElement* vertices = header_.FindElement("vertex");
    if (vertices == nullptr) return body_.Malformed("the header has no element 'vertex'");
    if (vertices->count > limits::kMaxMeshVertices) {
      return body_.Malformed(fmt::format("{} vertices; at most {} are allowed", vertices->count,
                                         limits::kMaxMeshVertices));
    }
    vertex_count_ = vertices->count;
    for (const PlyElement& element : header_.elements) {
      LATTICED_RETURN_IF_ERROR(ReadElement(element));
    }
    if (!mesh_.normals.empty()) mesh_.corner_normals = mesh_.corner_vertices;
    if (!mesh_.uvs.empty()) mesh_.corner_uvs = mesh_.corner_vertices;
    return FinishMesh("PLY", std::move(mesh_));
  }

 private:
  absl::Status ReadElement(const PlyElement& element) {
    LATTICED_RETURN_IF_ERROR(CheckSize(element));
    if (&element == header_.FindElement("vertex")) return ReadVertices(element);
    if (element.name == "face") return ReadFaces(element);
    if (element.name == "tristrips") return ReadStrips(element);
    for (uint64_t i = 0; i < element.count && !element.properties.empty(); ++i) {
      for (const PlyProperty& property : element.properties) {
        LATTICED_RETURN_IF_ERROR(SkipProperty(property));
      }
    }
    return absl::OkStatus();
  }

  // Checks the element's size before anything is allocated for it.
  absl::Status CheckSize(const PlyElement& element) const {
    const size_t record = body_.is_ascii() ? element.properties.size() : element.MinBinaryBytes();
    if (record == 0 || element.count <= body_.bytes_left() / record) return absl::OkStatus();
    return body_.Malformed(fmt::format("{} records of {} need more bytes than the {} that are left",
                                       element.count, Quoted(element.name), body_.bytes_left()));
  }

  absl::Status SkipProperty(const PlyProperty& property) {
    uint64_t length = 1;
    if (property.is_list()) {
      LATTICED_RETURN_IF_ERROR(body_.ReadListLength(property, &length));
    }
    return body_.Skip(*property.type, length);
  }

  absl::Status ReadVertices(const PlyElement& element) {
    enum Slot { kX, kY, kZ, kNx, kNy, kNz, kU, kV, kWeight, kSlots };
    const int columns[kSlots] = {
        element.FindProperty({"x"}, false),
        element.FindProperty({"y"}, false),
        element.FindProperty({"z"}, false),
        element.FindProperty({"nx"}, false),
        element.FindProperty({"ny"}, false),
        element.FindProperty({"nz"}, false),
        element.FindProperty({"s", "u", "texture_u", "texture_s"}, false),
        element.FindProperty({"t", "v", "texture_v", "texture_t"}, false),
        element.FindProperty({"weight"}, false),
    };
    for (int slot : {kX, kY, kZ}) {
      if (columns[slot] < 0) return body_.Malformed("vertices lack one of x, y, z");
    }
    const bool has_normals = columns[kNx] >= 0 && columns[kNy] >= 0 && columns[kNz] >= 0;
    const bool has_uvs = columns[kU] >= 0 && columns[kV] >= 0, has_weights = columns[kWeight] >= 0;
    std::vector<int> slot_of(element.properties.size(), -1);
    for (int slot = 0; slot < kSlots; ++slot) {
      if (columns[slot] >= 0) slot_of[static_cast<size_t>(columns[slot])] = slot;
    }
    LATTICED_RETURN_IF_ERROR(growth_.Reserve(
        element.count * (sizeof(Vec3d) + (has_normals ? sizeof(Vec3f) : 0) +
                         (has_uvs ? sizeof(Vec2f) : 0) + (has_weights ? sizeof(float) : 0))));
    mesh_.positions.reserve(element.count);
    if (has_normals) mesh_.normals.reserve(element.count);
    if (has_uvs) mesh_.uvs.reserve(element.count);
    if (has_weights) mesh_.weights.reserve(element.count);
    double values[kSlots] = {};
    for (uint64_t i = 0; i < element.count; ++i) {
      LATTICED_RETURN_IF_ERROR(ReadRecord(element, slot_of, values));
      mesh_.positions.push_back({values[kX], values[kY], values[kZ]});
      if (has_normals) mesh_.normals.push_back(ToFloat({values[kNx], values[kNy], values[kNz]}));
      if (has_uvs) {
        mesh_.uvs.push_back({static_cast<float>(values[kU]), static_cast<float>(values[kV])});
      }
      if (has_weights) mesh_.weights.push_back(static_cast<float>(values[kWeight]));
    }
    return absl::OkStatus();
  }

  // Reads the values of the properties that have a slot. They must be finite, also as floats.
  absl::Status ReadRecord(const PlyElement& element, const std::vector<int>& slot_of,
                          double* values) {
    for (size_t p = 0; p < slot_of.size(); ++p) {
      const PlyProperty& property = element.properties[p];
      if (slot_of[p] < 0) {
        LATTICED_RETURN_IF_ERROR(SkipProperty(property));
        continue;
      }
      double& value = values[slot_of[p]];
      LATTICED_RETURN_IF_ERROR(body_.Read(*property.type, &value));
      if (!std::isfinite(static_cast<float>(value))) {
        return body_.Malformed(fmt::format("a vertex's {} is not finite", Quoted(property.name)));
      }
    }
    return absl::OkStatus();
  }

  // Reads every record; `add` gets the indices of one list. An index appends up to `bytes_per_index` to the mesh.
  template <typename AddList>
  absl::Status ReadIndexLists(const PlyElement& element, uint64_t bytes_per_index,
                              const AddList& add) {
    const int column = element.FindProperty({"vertex_indices", "vertex_index"}, true);
    if (column >= 0 && !element.properties[static_cast<size_t>(column)].type->is_integer) {
      return body_.Malformed("vertex_indices are not integers");
    }
    if (column < 0 && element.count > 0) {
      return body_.Malformed(fmt::format("{} has no list vertex_indices", Quoted(element.name)));
    }
    std::vector<double> indices;
    for (uint64_t i = 0; i < element.count; ++i) {
      for (size_t p = 0; p < element.properties.size(); ++p) {
        const PlyProperty& property = element.properties[p];
        LATTICED_RETURN_IF_ERROR(static_cast<int>(p) == column ? ReadList(property, &indices)
                                                               : SkipProperty(property));
      }
      LATTICED_RETURN_IF_ERROR(
          growth_.Append(bytes_per_index * indices.size(), indices.capacity() * sizeof(double)));
      LATTICED_RETURN_IF_ERROR(add(indices));
    }
    return absl::OkStatus();
  }

  absl::Status ReadList(const PlyProperty& property, std::vector<double>* values) {
    uint64_t length = 0;
    LATTICED_RETURN_IF_ERROR(body_.ReadListLength(property, &length));
    if (length > values->capacity()) {
      LATTICED_RETURN_IF_ERROR(growth_.Reserve(3 * length * sizeof(double)));
    }
    values->resize(length);
    for (double& value : *values) {
      LATTICED_RETURN_IF_ERROR(body_.Read(*property.type, &value));
    }
    return absl::OkStatus();
  }

  absl::Status CheckIndex(double index) const {
    if (index >= 0 && index < static_cast<double>(vertex_count_)) return absl::OkStatus();
    return body_.Malformed(
        fmt::format("vertex index {} is out of range; the file has {}", index, vertex_count_));
  }

  absl::Status ReadFaces(const PlyElement& element) {
    constexpr uint64_t kCornerBytes = 2 * sizeof(uint32_t);  // and its part of the face's offset
    const auto add = [this](const std::vector<double>& indices) -> absl::Status {
      if (indices.size() < 3) {
        return body_.Malformed(fmt::format("a face has {} corners; 3 are needed", indices.size()));
      }
      return AddFace(indices);
    };
    return ReadIndexLists(element, kCornerBytes, add);
  }

  template <typename Indices>
  absl::Status AddFace(const Indices& indices) {
    if (mesh_.corner_count() + indices.size() >= PolygonMesh::kNoAttribute) {
      return body_.Malformed("too many corners");
    }
    for (double index : indices) {
      LATTICED_RETURN_IF_ERROR(CheckIndex(index));
      mesh_.corner_vertices.push_back(static_cast<uint32_t>(index));
    }
    mesh_.face_offsets.push_back(static_cast<uint32_t>(mesh_.corner_count()));
    return absl::OkStatus();
  }

  absl::Status ReadStrips(const PlyElement& element) {
    constexpr uint64_t kTriangleBytes = 4 * sizeof(uint32_t);
    const auto add = [this](const std::vector<double>& indices) -> absl::Status {
      size_t begin = 0;
      while (begin < indices.size()) {
        const auto end = static_cast<size_t>(
            std::find(indices.begin() + static_cast<ptrdiff_t>(begin), indices.end(), -1.0) -
            indices.begin());
        for (size_t i = begin; i + 2 < end; ++i) {  // every second triangle is reversed
          const bool odd = ((i - begin) & 1) != 0;
          const double a = indices[i + (odd ? 1 : 0)], b = indices[i + (odd ? 0 : 1)];
          const double c = indices[i + 2];
          if (a == b || b == c || c == a) continue;
          LATTICED_RETURN_IF_ERROR(AddFace(std::initializer_list<double>{a, b, c}));
        }
        begin = end + 1;
      }
      return absl::OkStatus();
    };
    return ReadIndexLists(element, kTriangleBytes, add);
  }

  const PlyHeader header_;
  PlyBody body_;
  uint64_t vertex_count_ = 0;
  PolygonMesh mesh_;
  MeshGrowth growth_;
};

}  // namespace

absl::StatusOr<PolygonMesh> ReadPly(std::string_view bytes, ReadingMemory* memory) {
  LATTICED_ASSIGN_OR_RETURN(PlyHeader header, ReadPlyHeader(bytes, memory));
  return PlyReader(bytes, std::move(header), memory).Read();
}

}  // namespace latticed
