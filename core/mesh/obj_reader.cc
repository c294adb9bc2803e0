// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Wavefront OBJ: v, vt, vn, f, g, o, usemtl; everything else is skipped.
//
// Faces may have any size, and any of the forms v, v/vt, v//vn, v/vt/vn; indices may be negative
// and may point forward. A face's group is its material (usemtl), else its group (g), else its
// object (o). Line ends LF, CRLF or CR; lines go on after a backslash. Texture coordinates have
// their origin below left.
//
// Errors   kInvalidArgument, reason MALFORMED_FILE, naming the line
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "core/mesh/mesh_io.h"
#include "core/mesh/mesh_reading.h"
#include "core/mesh/reading_memory.h"
#include "fmt/format.h"

namespace latticed {
namespace {

constexpr std::string_view kObj = "OBJ";
constexpr size_t kMostContinuedBytes = size_t{4}
                                       << 20;  // a face of 65,536 corners takes half of it

// The next word before a comment. A comment may begin inside a word.
std::string_view TakeField(std::string_view* line) {
  const std::string_view word = TakeWord(line);
  const size_t comment = word.find('#');
  if (comment == std::string_view::npos) return word;
  *line = {};
  return word.substr(0, comment);
}

std::string_view Trimmed(std::string_view text) {
  const size_t begin = text.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

// Splits off the next line, continuations joined into *joined, and counts the lines it took.
std::string_view TakeLine(std::string_view* text, std::string* joined, size_t* lines) {
  joined->clear();
  *lines = 0;
  while (true) {
    const std::string_view line = TakeTextLine(text);
    ++*lines;
    const bool continued = !line.empty() && line.back() == '\\' && !text->empty();
    if ((!continued && joined->empty()) || joined->size() > kMostContinuedBytes) return line;
    joined->append(line, 0, line.size() - (continued ? 1 : 0));
    joined->push_back(' ');
    if (!continued) return *joined;
  }
}

// More than a line of `size` bytes appends to vectors: "v 0 0 0" 24, "f 1 1 1" 20, an index of two bytes 4; a group's
// name makes an entry of a table and two strings.
uint64_t MostBytesOfLine(size_t size) { return 24 + 8 * size; }
uint64_t MostBytesOfGroup(size_t size) { return 224 + 3 * (size + 32); }

class ObjReader {
 public:
  explicit ObjReader(ReadingMemory* memory) : growth_(memory, &mesh_) {}

  absl::StatusOr<PolygonMesh> Read(std::string_view text) {
    constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
    if (text.substr(0, kByteOrderMark.size()) == kByteOrderMark) {
      text.remove_prefix(kByteOrderMark.size());
    }
    std::string joined;
    size_t lines = 0;
    for (line_ = 1; !text.empty(); line_ += lines) {
      const std::string_view line = TakeLine(&text, &joined, &lines);
      if (joined.size() > kMostContinuedBytes) return Malformed("a continued line of over 4 MiB");
      LATTICED_RETURN_IF_ERROR(growth_.Append(MostBytesOfLine(line.size()), beside_bytes_));
      LATTICED_RETURN_IF_ERROR(ReadLine(line));
    }
    return Finish();
  }

 private:
  // One of v, vt, vn: how many there are, and the highest index that a face used before it was
  // defined.
  struct Kind {
    std::string_view name;
    size_t count = 0;
    size_t forward_count = 0;
    size_t forward_line = 0;
  };

  absl::Status Malformed(std::string_view problem) const {
    return error::MalformedFile(kObj, fmt::format("line {}", line_), problem);
  }

  absl::Status ReadLine(std::string_view line) {
    const std::string_view keyword = TakeField(&line);
    if (keyword == "v") return ReadPosition(line);
    if (keyword == "f") return ReadFace(line);
    if (keyword == "vn") return ReadNormal(line);
    if (keyword == "vt") return ReadUv(line);
    if (keyword == "usemtl") return SetGroup(&material_, line);
    if (keyword == "g") return SetGroup(&group_, line);
    if (keyword == "o") return SetGroup(&object_, line);
    return absl::OkStatus();
  }

  absl::Status ReadNumbers(std::string_view line, int needed, double* values) {
    for (int i = 0; i < needed; ++i) {
      const std::string_view word = TakeField(&line);
      if (!ParseNumber(word, &values[i])) return Malformed(NumberProblem(word));
    }
    return absl::OkStatus();
  }

  absl::Status ReadPosition(std::string_view line) {
    double p[3];
    LATTICED_RETURN_IF_ERROR(ReadNumbers(line, 3, p));
    mesh_.positions.push_back({p[0], p[1], p[2]});
    ++vertices_.count;
    return absl::OkStatus();
  }

  absl::Status ReadNormal(std::string_view line) {
    double n[3];
    LATTICED_RETURN_IF_ERROR(ReadNumbers(line, 3, n));
    mesh_.normals.push_back(ToFloat({n[0], n[1], n[2]}));
    ++normals_.count;
    if (!IsFinite(ToDouble(mesh_.normals.back()))) return Malformed("the normal is too long");
    return absl::OkStatus();
  }

  absl::Status ReadUv(std::string_view line) {
    double uv[2] = {0, 0};
    std::string_view second = line;
    (void)TakeField(&second);
    const int given = TakeField(&second).empty() ? 1 : 2;  // v is optional
    LATTICED_RETURN_IF_ERROR(ReadNumbers(line, given, uv));
    mesh_.uvs.push_back({static_cast<float>(uv[0]), static_cast<float>(uv[1])});
    ++uvs_.count;
    if (!std::isfinite(mesh_.uvs.back().x) || !std::isfinite(mesh_.uvs.back().y)) {
      return Malformed("the texture coordinate is too large");
    }
    return absl::OkStatus();
  }

  absl::Status SetGroup(std::string* name, std::string_view line) {
    *name = std::string(Trimmed(line));
    const std::string& shown = !material_.empty() ? material_ : !group_.empty() ? group_ : object_;
    const auto [it, added] =
        group_ids_.try_emplace(shown, static_cast<uint32_t>(group_ids_.size()));
    if (added) beside_bytes_ += MostBytesOfGroup(shown.size());
    current_group_ = it->second;
    return absl::OkStatus();
  }

  absl::Status ReadFace(std::string_view line) {
    uint32_t corners = 0;
    for (std::string_view word = TakeField(&line); !word.empty(); word = TakeField(&line)) {
      LATTICED_RETURN_IF_ERROR(ReadCorner(word));
      if (++corners > limits::kMaxFaceCorners) {
        return Malformed(fmt::format("a face has more than {} corners", limits::kMaxFaceCorners));
      }
    }
    if (corners < 3) return Malformed(fmt::format("a face has {} corners; 3 are needed", corners));
    if (mesh_.face_count() >= limits::kMaxMeshFaces) {
      return Malformed(fmt::format("more than {} faces", limits::kMaxMeshFaces));
    }
    mesh_.face_offsets.push_back(static_cast<uint32_t>(mesh_.corner_count()));
    mesh_.face_groups.push_back(current_group_);
    return absl::OkStatus();
  }

  // v, v/vt, v//vn or v/vt/vn.
  absl::Status ReadCorner(std::string_view word) {
    uint32_t indices[3] = {PolygonMesh::kNoAttribute, PolygonMesh::kNoAttribute,
                           PolygonMesh::kNoAttribute};
    Kind* const kinds[3] = {&vertices_, &uvs_, &normals_};
    std::string_view rest = word;
    for (int i = 0; i < 3; ++i) {
      const size_t slash = rest.find('/');
      const std::string_view field = rest.substr(0, slash);
      if (!field.empty() || i == 0) {
        LATTICED_RETURN_IF_ERROR(ReadIndex(field, kinds[i], &indices[i]));
      }
      if (slash == std::string_view::npos) break;
      if (i == 2) return Malformed(fmt::format("{} has more than three indices", Quoted(word)));
      rest.remove_prefix(slash + 1);
    }
    if (mesh_.corner_count() >= PolygonMesh::kNoAttribute) return Malformed("too many corners");
    mesh_.corner_vertices.push_back(indices[0]);
    AddCornerAttribute(mesh_, indices[1], &mesh_.corner_uvs);
    AddCornerAttribute(mesh_, indices[2], &mesh_.corner_normals);
    return absl::OkStatus();
  }

  absl::Status ReadIndex(std::string_view field, Kind* kind, uint32_t* index) {
    int64_t value = 0;
    if (!ParseInteger(field, &value)) return Malformed(NumberProblem(field));
    const auto count = static_cast<int64_t>(kind->count);
    if (value == 0 || value < -count || value > static_cast<int64_t>(limits::kMaxMeshVertices)) {
      return Malformed(OutOfRange(*kind, value));
    }
    *index = static_cast<uint32_t>(value > 0 ? value - 1 : count + value);
    if (value > count && static_cast<size_t>(value) > kind->forward_count) {
      kind->forward_count = static_cast<size_t>(value);
      kind->forward_line = line_;
    }
    return absl::OkStatus();
  }

  static std::string OutOfRange(const Kind& kind, int64_t index) {
    return fmt::format("{} index {} is out of range; the file has {}", kind.name, index,
                       kind.count);
  }

  absl::StatusOr<PolygonMesh> Finish() {
    for (const Kind* kind : {&vertices_, &uvs_, &normals_}) {
      if (kind->forward_count <= kind->count) continue;
      return error::MalformedFile(kObj, fmt::format("line {}", kind->forward_line),
                                  OutOfRange(*kind, static_cast<int64_t>(kind->forward_count)));
    }
    NameGroups();
    return FinishMesh(kObj, std::move(mesh_));
  }

  // Groups are in the order of their first face. Groups without faces are left out; so are all
  // groups where no face is in a named one.
  void NameGroups() {
    std::vector<uint32_t> renumbered(group_ids_.size(), PolygonMesh::kNoAttribute);
    std::vector<std::string> names(group_ids_.size());
    for (const auto& [name, id] : group_ids_) names[id] = name;
    for (uint32_t& group : mesh_.face_groups) {
      if (renumbered[group] == PolygonMesh::kNoAttribute) {
        renumbered[group] = static_cast<uint32_t>(mesh_.group_names.size());
        mesh_.group_names.push_back(names[group].empty() ? "default" : names[group]);
      }
      group = renumbered[group];
    }
    if (group_ids_.size() > 1 && !mesh_.group_names.empty()) return;
    mesh_.group_names.clear();
    mesh_.face_groups.clear();
  }

  PolygonMesh mesh_;
  MeshGrowth growth_;
  uint64_t beside_bytes_ = 0;  // of groups
  Kind vertices_{"vertex"}, uvs_{"texture coordinate"}, normals_{"normal"};
  std::string material_, group_, object_;
  std::map<std::string, uint32_t> group_ids_{{"", 0}};
  uint32_t current_group_ = 0;
  size_t line_ = 1;
};

}  // namespace

absl::StatusOr<PolygonMesh> ReadObj(std::string_view bytes, ReadingMemory* memory) {
  return ObjReader(memory).Read(bytes);
}

}  // namespace latticed
