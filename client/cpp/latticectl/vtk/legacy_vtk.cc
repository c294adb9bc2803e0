// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/vtk/legacy_vtk.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_split.h"
#include "absl/strings/string_view.h"
#include "client/cpp/latticectl/vtk/vtk_numbers.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

using Words = std::vector<std::string>;

// Reads a file from its begin.
class LegacyReader {
 public:
  explicit LegacyReader(std::string_view bytes) : bytes_(bytes) {}

  size_t at() const { return at_; }
  size_t line() const { return line_; }  // where the last line began
  // A line without its end; nullopt at the end of the file.
  std::optional<std::string_view> Line() {
    if (at_ >= bytes_.size()) return std::nullopt;
    line_ = at_;
    const size_t end = std::min(bytes_.find('\n', at_), bytes_.size());
    const std::string_view line = bytes_.substr(at_, end - at_);
    at_ = std::min(end + 1, bytes_.size());
    return line;
  }
  // The words of the next line that is not empty.
  Words WordsOfLine() {
    while (const auto line = Line()) {
      Words words = absl::StrSplit(absl::string_view(line->data(), line->size()),
                                   absl::ByAnyChar(" \t\r"), absl::SkipEmpty());
      if (!words.empty()) return words;
    }
    return {};
  }
  absl::StatusOr<std::vector<double>> Numbers(uint64_t count, const std::string& type,
                                              bool is_text) {
    if (is_text) return TextNumbers(bytes_, count, at_);
    return BinaryNumbers(bytes_, count, type, std::endian::big, at_);
  }

 private:
  std::string_view bytes_;
  size_t at_ = 0, line_ = 0;
};

// Passes over a FIELD of the data set, as TIME and CYCLE.
absl::Status SkipField(const Words& words, bool is_text, LegacyReader& reader) {
  uint32_t arrays = 0;
  if (words.size() != 3 || !absl::SimpleAtoi(words[2], &arrays)) {
    return absl::InvalidArgumentError("has a FIELD without a number of arrays");
  }
  for (uint32_t n = 0; n < arrays; ++n) {
    const Words array = reader.WordsOfLine();
    uint32_t components = 0, tuples = 0;
    if (array.size() != 4 || !absl::SimpleAtoi(array[1], &components) ||
        !absl::SimpleAtoi(array[2], &tuples)) {
      return absl::InvalidArgumentError("has a FIELD whose arrays cannot be read");
    }
    const uint64_t count = uint64_t{components} * tuples;
    LATTICED_RETURN_IF_ERROR(reader.Numbers(count, array[3], is_text).status());
  }
  return absl::OkStatus();
}

// Where the word begins a line, from `from` on; npos if nowhere.
size_t FindLine(std::string_view bytes, const std::string& word, size_t from) {
  const size_t found = bytes.find("\n" + word, from);
  return found == std::string_view::npos ? found : found + 1;
}

// Adds where the moves are written: in the point data, or at the end of the file.
absl::Status AddMoves(std::string_view bytes, size_t from, LegacyVtk& parts) {
  if (FindLine(bytes, "VECTORS displacement ", from) != std::string_view::npos) {
    return absl::InvalidArgumentError(
        "already has point data named displacement: deform the file at rest");
  }
  const size_t count = parts.points.size();
  const std::string head = fmt::format("POINT_DATA {}", count);
  VtkSplice moves{.before = "VECTORS displacement double\n",
                  .after = "\n",
                  .what = VtkSplice::What::kMoves,
                  .points = count};
  size_t section = FindLine(bytes, head, from);
  while (section != std::string_view::npos && section + head.size() < bytes.size() &&
         absl::ascii_isdigit(static_cast<unsigned char>(bytes[section + head.size()]))) {
    section = FindLine(bytes, head, section);
  }
  if (section == std::string_view::npos) {
    moves.begin = moves.end = bytes.size();
    moves.before = fmt::format("\n{}\n{}", head, moves.before);
  } else {
    moves.begin = moves.end = std::min(bytes.find('\n', section), bytes.size() - 1) + 1;
  }
  parts.splices.push_back(std::move(moves));
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<LegacyVtk> ParseLegacyVtk(std::string_view bytes) {
  LegacyReader reader(bytes);
  const auto first = reader.Line();
  if (!first.has_value() || !first->starts_with("# vtk DataFile Version")) {
    return absl::InvalidArgumentError("is no legacy VTK file: it does not begin with '# vtk'");
  }
  (void)reader.Line();  // a title
  const Words coding = reader.WordsOfLine(), dataset = reader.WordsOfLine();
  if (coding.empty() || (coding[0] != "ASCII" && coding[0] != "BINARY")) {
    return absl::InvalidArgumentError("its third line is neither ASCII nor BINARY");
  }
  LegacyVtk parts{.is_text = coding[0] == "ASCII"};
  if (dataset.size() != 2 || dataset[0] != "DATASET" ||
      (dataset[1] != "UNSTRUCTURED_GRID" && dataset[1] != "POLYDATA" &&
       dataset[1] != "STRUCTURED_GRID")) {
    return absl::InvalidArgumentError(
        "is no data set with points: UNSTRUCTURED_GRID, POLYDATA and STRUCTURED_GRID are read");
  }
  while (true) {
    const Words words = reader.WordsOfLine();
    uint32_t count = 0;
    if (words.empty()) return absl::InvalidArgumentError("has no POINTS");
    if (words[0] == "FIELD") {
      LATTICED_RETURN_IF_ERROR(SkipField(words, parts.is_text, reader));
    } else if (words[0] == "POINTS") {
      if (words.size() != 3 || !absl::SimpleAtoi(words[1], &count)) {
        return absl::InvalidArgumentError("its POINTS have no number and type");
      }
      if (words[2] != "float" && words[2] != "double") {
        return absl::InvalidArgumentError(
            fmt::format("its points are of type {}; float and double are read", words[2]));
      }
      LATTICED_ASSIGN_OR_RETURN(const auto numbers,
                                reader.Numbers(uint64_t{3} * count, words[2], parts.is_text));
      parts.points = PointsFromNumbers(numbers);
      parts.splices.push_back({.begin = reader.line(),
                               .end = reader.at(),
                               .before = fmt::format("POINTS {} double\n", count),
                               .points = count});
      break;
    } else if (words[0] != "DIMENSIONS" && words[0] != "METADATA" && words[0] != "INFORMATION") {
      return absl::InvalidArgumentError(fmt::format("has {} before its POINTS", words[0]));
    }
  }
  LATTICED_RETURN_IF_ERROR(AddMoves(bytes, reader.at(), parts));
  return parts;
}

}  // namespace latticed::client
