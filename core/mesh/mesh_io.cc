// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

#include "core/mesh/mesh_io.h"

#include <array>

#include "absl/strings/match.h"
#include "core/base/error.h"
#include "core/base/limits.h"
#include "fmt/format.h"

namespace latticed {
namespace {

struct FormatNames {
  MeshFormat format;
  std::string_view name, extension;
};
constexpr std::array<FormatNames, 6> kFormats = {{
    {MeshFormat::kObj, "OBJ", "obj"},
    {MeshFormat::kPly, "PLY", "ply"},
    {MeshFormat::kStl, "STL", "stl"},
    {MeshFormat::kGlb, "GLB", "glb"},
    {MeshFormat::kDraco, "DRACO", "drc"},
    {MeshFormat::kUsd, "USD", "usda"},
}};

const FormatNames& NamesOf(MeshFormat format) { return kFormats[static_cast<size_t>(format)]; }

bool SameButForCase(std::string_view a, std::string_view b) {
  return absl::EqualsIgnoreCase({a.data(), a.size()}, {b.data(), b.size()});
}

}  // namespace

absl::StatusOr<MeshFormat> MeshFormatFromFileName(std::string_view file_name) {
  const size_t dot = file_name.rfind('.');
  if (dot != std::string_view::npos) {
    for (const FormatNames& known : kFormats) {
      if (SameButForCase(file_name.substr(dot + 1), known.extension)) return known.format;
    }
  }
  return error::InvalidField("format", fmt::format("'{}' is no known mesh file; known are .obj, "
                                                   ".ply, .stl, .glb and .drc, and to write .usda",
                                                   file_name));
}

std::string_view MeshFormatName(MeshFormat format) { return NamesOf(format).name; }
std::string_view MeshFormatExtension(MeshFormat format) { return NamesOf(format).extension; }

absl::StatusOr<PolygonMesh> ReadMesh(MeshFormat format, std::string_view bytes,
                                     ReadingMemory* memory) {
  if (bytes.empty()) return error::MalformedFile(MeshFormatName(format), "byte 0", "it is empty");
  if (bytes.size() > limits::kMaxMeshBytes) {
    return error::InvalidField("data", fmt::format("{} bytes; at most {} are allowed", bytes.size(),
                                                   limits::kMaxMeshBytes));
  }
  switch (format) {
    case MeshFormat::kObj:
      return ReadObj(bytes, memory);
    case MeshFormat::kPly:
      return ReadPly(bytes, memory);
    case MeshFormat::kStl:
      return ReadStl(bytes, memory);
    case MeshFormat::kGlb:
      return ReadGlb(bytes, memory);
    case MeshFormat::kDraco:
    case MeshFormat::kUsd:
      break;
  }
  return error::Unimplemented(fmt::format("reading {} here", MeshFormatName(format)));
}

}  // namespace latticed
