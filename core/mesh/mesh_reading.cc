// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

#include "core/mesh/mesh_reading.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>

#include "core/base/error.h"
#include "fast_float/fast_float.h"
#include "fmt/format.h"

namespace latticed {
namespace {

// NUL counts as blank: some exporters pad text files with it.
bool IsBlank(char c) { return c == ' ' || (c >= '\t' && c <= '\r') || c == '\0'; }

std::string_view WithoutPlus(std::string_view word) {
  const bool plus = word.size() > 1 && word[0] == '+' && word[1] != '-' && word[1] != '+';
  return plus ? word.substr(1) : word;
}

template <typename T>
void CompleteAttribute(size_t corners, std::vector<T>* values, std::vector<uint32_t>* list) {
  if (std::ranges::all_of(*list, [](uint32_t i) { return i == PolygonMesh::kNoAttribute; })) {
    *values = {};
    *list = {};
  } else {
    list->resize(corners, PolygonMesh::kNoAttribute);
  }
}

}  // namespace

std::string_view TakeWord(std::string_view* text) {
  size_t begin = 0;
  while (begin < text->size() && IsBlank((*text)[begin])) ++begin;
  size_t end = begin;
  while (end < text->size() && !IsBlank((*text)[end])) ++end;
  const std::string_view word = text->substr(begin, end - begin);
  text->remove_prefix(end);
  return word;
}

std::string_view TakeTextLine(std::string_view* text) {
  const size_t end = std::min(text->find_first_of("\r\n"), text->size());
  const std::string_view line = text->substr(0, end);
  const bool crlf = text->substr(end, 2) == "\r\n";
  text->remove_prefix(std::min(text->size(), end + (crlf ? 2 : 1)));
  return line;
}

bool ParseNumber(std::string_view word, double* value) {
  word = WithoutPlus(word);
  const char* end = word.data() + word.size();
  const auto result = fast_float::from_chars(word.data(), end, *value);
  return result.ec == std::errc() && result.ptr == end && std::isfinite(*value);
}

bool ParseInteger(std::string_view word, int64_t* value) {
  word = WithoutPlus(word);
  const char* end = word.data() + word.size();
  const auto result = std::from_chars(word.data(), end, *value);
  return result.ec == std::errc() && result.ptr == end;
}

std::string NumberProblem(std::string_view word) {
  if (word.empty()) return "a number is missing";
  word = WithoutPlus(word);
  double value = 0;
  const auto result = fast_float::from_chars(word.data(), word.data() + word.size(), value);
  const bool is_number =
      result.ptr == word.data() + word.size() && result.ec != std::errc::invalid_argument;
  if (is_number && !std::isfinite(value)) {
    return fmt::format("{} is not finite; all numbers must be", Quoted(word));
  }
  if (is_number) return fmt::format("{} is not an integer within range", Quoted(word));
  return fmt::format("{} is not a number", Quoted(word));
}

std::string LineAt(std::string_view text, size_t offset) {
  const std::string_view before = text.substr(0, offset);
  return fmt::format("line {}", 1 + std::count(before.begin(), before.end(), '\n'));
}

std::string Quoted(std::string_view word) {
  constexpr size_t kLongest = 40;
  std::string quoted = "'";
  for (char c : word.substr(0, kLongest)) quoted += c >= ' ' && c <= '~' ? c : '?';
  return quoted + (word.size() > kLongest ? "…'" : "'");
}

size_t VertexWelder::Hash::operator()(const Key& key) const {
  uint64_t hash = std::bit_cast<uint32_t>(key.weight);
  for (int axis = 0; axis < 3; ++axis) {
    hash ^= std::bit_cast<uint64_t>(key.position[axis]);
    hash *= 0x9e3779b97f4a7c15u;  // 2^64 / golden ratio
    hash ^= hash >> 32;
  }
  return hash;
}

uint32_t VertexWelder::Add(Vec3d position, float weight) {
  position += Vec3d{};  // -0 + 0 is +0
  const auto [it, added] =
      index_.try_emplace(Key{position, weight}, static_cast<uint32_t>(positions_.size()));
  if (added) positions_.push_back(position);
  return it->second;
}

void AddCornerAttribute(const PolygonMesh& mesh, uint32_t index, std::vector<uint32_t>* list) {
  if (index == PolygonMesh::kNoAttribute && list->empty()) return;
  list->resize(mesh.corner_count() - 1, PolygonMesh::kNoAttribute);
  list->push_back(index);
}

absl::StatusOr<PolygonMesh> FinishMesh(std::string_view format, PolygonMesh mesh) {
  CompleteAttribute(mesh.corner_count(), &mesh.normals, &mesh.corner_normals);
  CompleteAttribute(mesh.corner_count(), &mesh.uvs, &mesh.corner_uvs);
  if (absl::Status status = Validate(mesh); !status.ok()) {
    return error::MalformedFile(format, "at its end", std::string(status.message()));
  }
  return mesh;
}

}  // namespace latticed
