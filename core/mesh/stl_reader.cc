// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// STL, ascii and binary (stl_layout.h).
//
// A file is binary when its size fits the count, also when its header starts with "solid". Vertices
// with the same bits are one. Facet normals are not kept: they say no more than the facets do. In
// an ascii file of several solids each is a group.
//
// Errors   kInvalidArgument, reason MALFORMED_FILE, naming the line or byte

#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "core/mesh/little_endian.h"
#include "core/mesh/mesh_io.h"
#include "core/mesh/mesh_reading.h"
#include "core/mesh/reading_memory.h"
#include "core/mesh/stl_layout.h"
#include "fmt/format.h"

namespace latticed {
namespace {

constexpr std::string_view kStl = "STL";
constexpr size_t kFacetNormalBytes = 3 * sizeof(float);

bool StartsWithSolid(std::string_view bytes) { return TakeWord(&bytes) == "solid"; }

uint64_t AnnouncedBytes(std::string_view bytes) {
  return stl::kPreambleBytes +
         uint64_t{stl::kFacetBytes} * LoadLittleEndian<uint32_t>(&bytes[stl::kHeaderBytes]);
}

bool IsBinary(std::string_view bytes) {
  if (bytes.size() < stl::kPreambleBytes) return false;
  if (AnnouncedBytes(bytes) == bytes.size()) return true;
  // Some binary files start with "solid", and some have bytes after the last facet: NUL tells them.
  const bool has_nul = bytes.substr(0, stl::kPreambleBytes).find('\0') != std::string_view::npos;
  return !StartsWithSolid(bytes) || (has_nul && AnnouncedBytes(bytes) < bytes.size());
}

constexpr size_t kMostNameBytes = 1'024;  // of a solid; the rest of a longer name is left out
// More than a facet appends: three positions with their entries in the table, three corners, an offset and a group.
constexpr uint64_t kMostFacetBytes =
    3 * (sizeof(Vec3d) + VertexWelder::kNodeBytes) + 5 * sizeof(uint32_t);

absl::StatusOr<PolygonMesh> ReadBinary(std::string_view bytes, ReadingMemory* memory) {
  const uint32_t count = LoadLittleEndian<uint32_t>(&bytes[stl::kHeaderBytes]);
  if (AnnouncedBytes(bytes) > bytes.size()) {
    return error::MalformedFile(kStl, fmt::format("byte {}", stl::kHeaderBytes),
                                fmt::format("{} facets need {} bytes, the file has {}", count,
                                            AnnouncedBytes(bytes), bytes.size()));
  }
  if (count > limits::kMaxMeshFaces) {
    return error::MalformedFile(
        kStl, fmt::format("byte {}", stl::kHeaderBytes),
        fmt::format("{} facets; at most {} are allowed", count, limits::kMaxMeshFaces));
  }
  PolygonMesh mesh;
  MeshGrowth growth(memory, &mesh);
  LATTICED_RETURN_IF_ERROR(growth.Reserve((uint64_t{4} * count + 1) * sizeof(uint32_t)));
  mesh.corner_vertices.reserve(size_t{3} * count);
  mesh.face_offsets.reserve(size_t{count} + 1);
  VertexWelder welder(&mesh.positions);
  for (uint32_t f = 0; f < count; ++f) {
    LATTICED_RETURN_IF_ERROR(growth.Append(kMostFacetBytes, welder.MemoryBytes()));
    const size_t offset = stl::kPreambleBytes + size_t{stl::kFacetBytes} * f;
    for (size_t corner = 0; corner < 3; ++corner) {
      const char* vertex = &bytes[offset + kFacetNormalBytes + corner * 3 * sizeof(float)];
      const Vec3d position = ToDouble(LoadLittleEndian<Vec3f>(vertex));
      if (!IsFinite(position)) {
        return error::MalformedFile(kStl, fmt::format("byte {}", offset),
                                    fmt::format("facet {} is not finite", f));
      }
      mesh.corner_vertices.push_back(welder.Add(position));
    }
    mesh.face_offsets.push_back(static_cast<uint32_t>(mesh.corner_count()));
  }
  return FinishMesh(kStl, std::move(mesh));
}

class AsciiReader {
 public:
  AsciiReader(std::string_view text, ReadingMemory* memory)
      : text_(text), rest_(text), growth_(memory, &mesh_) {}

  absl::StatusOr<PolygonMesh> Read() {
    while (true) {
      const std::string_view word = TakeWord(&rest_);
      absl::Status status;
      if (word.empty()) break;
      if (word == "solid") {
        status = BeginSolid();
      } else if (word == "facet") {
        status = ReadFacet();
      } else if (word == "endsolid") {
        (void)TakeName();
        in_solid_ = false;
      } else {
        status = Malformed(fmt::format("{} where a facet or endsolid belongs", Quoted(word)));
      }
      if (!status.ok()) return status;
    }
    if (in_solid_) return Malformed("the file ends before endsolid");
    if (mesh_.group_names.size() < 2) mesh_.group_names = {}, mesh_.face_groups = {};
    return FinishMesh(kStl, std::move(mesh_));
  }

 private:
  absl::Status Malformed(std::string_view problem) const {
    return error::MalformedFile(kStl, LineAt(text_, text_.size() - rest_.size()), problem);
  }

  std::string TakeName() {
    std::string_view line = rest_.substr(0, rest_.find('\n'));
    rest_.remove_prefix(line.size());
    std::string name;
    for (std::string_view word = TakeWord(&line); !word.empty() && name.size() < kMostNameBytes;
         word = TakeWord(&line)) {
      if (!name.empty()) name += ' ';
      name += word.substr(0, kMostNameBytes);
    }
    return name;
  }

  absl::Status BeginSolid() {
    const std::string name = TakeName();
    growth_.NoteName(name.size());
    LATTICED_RETURN_IF_ERROR(
        growth_.Append(sizeof(std::string) + name.size(), welder_.MemoryBytes()));
    mesh_.group_names.push_back(name.empty() ? fmt::format("solid {}", mesh_.group_names.size() + 1)
                                             : name);
    in_solid_ = true;
    return absl::OkStatus();
  }

  absl::Status Expect(std::string_view wanted) {
    const std::string_view word = TakeWord(&rest_);
    if (word == wanted) return absl::OkStatus();
    if (word.empty()) return Malformed(fmt::format("the file ends where {} belongs", wanted));
    return Malformed(fmt::format("{} where {} belongs", Quoted(word), wanted));
  }

  absl::Status ReadVector(Vec3d* vector) {
    for (int axis = 0; axis < 3; ++axis) {
      const std::string_view word = TakeWord(&rest_);
      double value = 0;
      if (!ParseNumber(word, &value)) return Malformed(NumberProblem(word));
      (*vector)[axis] = value;
    }
    return absl::OkStatus();
  }

  // The normal is not kept, and degenerate facets are often given one of NaN.
  absl::Status SkipNormal() {
    LATTICED_RETURN_IF_ERROR(Expect("normal"));
    for (int axis = 0; axis < 3; ++axis) (void)TakeWord(&rest_);
    return absl::OkStatus();
  }

  absl::Status ReadFacet() {
    if (!in_solid_) return Malformed("a facet outside a solid");
    LATTICED_RETURN_IF_ERROR(growth_.Append(kMostFacetBytes, welder_.MemoryBytes()));
    LATTICED_RETURN_IF_ERROR(SkipNormal());
    LATTICED_RETURN_IF_ERROR(Expect("outer"));
    LATTICED_RETURN_IF_ERROR(Expect("loop"));
    for (int corner = 0; corner < 3; ++corner) {
      Vec3d position;
      LATTICED_RETURN_IF_ERROR(Expect("vertex"));
      LATTICED_RETURN_IF_ERROR(ReadVector(&position));
      mesh_.corner_vertices.push_back(welder_.Add(position));
    }
    LATTICED_RETURN_IF_ERROR(Expect("endloop"));
    mesh_.face_offsets.push_back(static_cast<uint32_t>(mesh_.corner_count()));
    mesh_.face_groups.push_back(static_cast<uint32_t>(mesh_.group_names.size() - 1));
    return Expect("endfacet");
  }

  const std::string_view text_;
  std::string_view rest_;
  PolygonMesh mesh_;
  VertexWelder welder_{&mesh_.positions};
  MeshGrowth growth_;
  bool in_solid_ = false;
};

}  // namespace

absl::StatusOr<PolygonMesh> ReadStl(std::string_view bytes, ReadingMemory* memory) {
  if (IsBinary(bytes)) return ReadBinary(bytes, memory);
  if (StartsWithSolid(bytes)) return AsciiReader(bytes, memory).Read();
  return error::MalformedFile(
      kStl, "byte 0",
      fmt::format("{} bytes that do not start with 'solid' are less than a binary header",
                  bytes.size()));
}

}  // namespace latticed
