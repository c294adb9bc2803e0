// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/vtk/vtk_file.h"

#include <bit>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <utility>

#include "absl/strings/ascii.h"
#include "client/cpp/latticectl/vtk/legacy_vtk.h"
#include "client/cpp/latticectl/vtk/xml_vtk.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

constexpr std::string_view kMovesName = "displacement";  // in VtkSplice::before of every kMoves

void AppendBigEndian(double number, std::string& to) {
  const auto bits = std::bit_cast<uint64_t>(number);
  for (int shift = 56; shift >= 0; shift -= 8) to += static_cast<char>(bits >> shift);
}

void AppendNumbers(Vec3d p, bool is_text, std::string& to) {
  if (is_text) {
    fmt::format_to(std::back_inserter(to), "{} {} {}\n", p.x, p.y, p.z);
  } else {
    for (int axis = 0; axis < 3; ++axis) AppendBigEndian(p[axis], to);
  }
}

std::string LowerExtensionOf(const std::string& path) {
  return absl::AsciiStrToLower(std::filesystem::path(path).extension().string());
}

}  // namespace

absl::StatusOr<VtkFile> VtkFile::Parse(std::string bytes, bool is_xml) {
  VtkFile file;
  if (is_xml) {
    LATTICED_ASSIGN_OR_RETURN(auto parts, ParseXmlVtk(bytes));
    file.points_ = std::move(parts.points);
    file.splices_ = std::move(parts.splices);
  } else {
    LATTICED_ASSIGN_OR_RETURN(auto parts, ParseLegacyVtk(bytes));
    file.points_ = std::move(parts.points);
    file.splices_ = std::move(parts.splices);
    file.is_text_ = parts.is_text;
  }
  file.bytes_ = std::move(bytes);
  return file;
}

std::string VtkFile::WithPoints(std::span<const Vec3d> points) const {
  std::string out;
  out.reserve(bytes_.size() + points.size() * 2 * 3 * sizeof(double));
  size_t at = 0;
  for (const VtkSplice& splice : splices_) {
    out.append(bytes_, at, splice.begin - at);
    out += splice.before;
    for (size_t n = splice.first_point; n < splice.first_point + splice.points; ++n) {
      const bool is_move = splice.what == VtkSplice::What::kMoves;
      AppendNumbers(is_move ? points[n] - points_[n] : points[n], is_text_, out);
    }
    out += splice.after + splice.rest + splice.closing;
    at = splice.end;
  }
  return out.append(bytes_, at);
}

absl::StatusOr<std::string> VtkFile::WithVectors(std::string_view name,
                                                 std::span<const Vec3d> vectors) const {
  if (bytes_.find(name) != std::string::npos) {
    return absl::InvalidArgumentError(fmt::format("already has point data named {}", name));
  }
  std::string out;
  out.reserve(bytes_.size() + vectors.size() * 3 * sizeof(double));
  size_t at = 0;
  for (const VtkSplice& splice : splices_) {
    if (splice.what != VtkSplice::What::kMoves) continue;
    out.append(bytes_, at, splice.begin - at);
    std::string before = splice.before;
    before.replace(before.rfind(kMovesName), kMovesName.size(), name);
    out += before;
    for (size_t n = splice.first_point; n < splice.first_point + splice.points; ++n) {
      AppendNumbers(vectors[n], is_text_, out);
    }
    out += splice.after + splice.closing;
    at = splice.end;
  }
  return out.append(bytes_, at);
}

bool IsXmlVtkFileName(const std::string& path) {
  const std::string extension = LowerExtensionOf(path);
  return extension == ".vtu" || extension == ".vtp" || extension == ".vts";
}

bool IsVtkFileName(const std::string& path) {
  return LowerExtensionOf(path) == ".vtk" || IsXmlVtkFileName(path);
}

}  // namespace latticed::client
