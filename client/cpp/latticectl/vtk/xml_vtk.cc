// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/vtk/xml_vtk.h"

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/string_view.h"
#include "client/cpp/latticectl/vtk/vtk_numbers.h"
#include "client/cpp/latticectl/vtk/xml_array.h"
#include "client/cpp/latticectl/vtk/xml_tags.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

constexpr char kMovesHead[] =
    "<DataArray type=\"Float64\" Name=\"displacement\" NumberOfComponents=\"3\" "
    "format=\"ascii\">\n";
constexpr char kPointsHead[] =
    "<DataArray type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\" format=\"ascii\">\n";
constexpr char kIsDeformed[] = "already has point data named displacement: deform the file at rest";
constexpr char kArrayEnd[] = "</DataArray>";

absl::Status Wrong(const std::string& problem) { return absl::InvalidArgumentError(problem); }

class XmlVtkParser {
 public:
  explicit XmlVtkParser(std::string_view bytes) : bytes_(bytes) {}

  absl::StatusOr<XmlVtk> Parse() {
    LATTICED_ASSIGN_OR_RETURN(tags_, XmlTagsOf(bytes_));
    LATTICED_RETURN_IF_ERROR(ReadHead());
    for (at_ = 1; at_ < tags_.size(); ++at_) {
      const XmlTag& tag = tags_[at_];
      if (tag.name == "Piece") LATTICED_RETURN_IF_ERROR(ReadPiece());
    }
    if (parts_.splices.empty()) return Wrong("has no Piece with Points");
    std::ranges::sort(parts_.splices, {}, &VtkSplice::begin);
    return std::move(parts_);
  }

 private:
  absl::Status ReadHead() {
    const XmlTag& file = tags_.front();
    const std::string_view type = file.Value("type");
    if (type != "UnstructuredGrid" && type != "PolyData" && type != "StructuredGrid") {
      return Wrong(fmt::format(
          "is of type '{}'; UnstructuredGrid, PolyData and StructuredGrid are read", type));
    }
    if (file.Value("byte_order") == "BigEndian") coding_.order = std::endian::big;
    if (file.Value("header_type") == "UInt64") coding_.count_bytes = 8;
    const std::string_view compressor = file.Value("compressor");
    coding_.is_compressed = !compressor.empty();
    if (coding_.is_compressed && compressor != "vtkZLibDataCompressor") {
      return Wrong(fmt::format(
          "is compressed by {}; plain arrays and vtkZLibDataCompressor are read", compressor));
    }
    return absl::OkStatus();
  }

  // From a Piece to its end.
  absl::Status ReadPiece() {
    const size_t piece = at_;
    const size_t before = parts_.points.size();
    size_t points = 0, data = 0;  // tags
    while (++at_ < tags_.size() && tags_[at_].name != "/Piece") {
      if (tags_[at_].name == "Points") points = at_;
      if (tags_[at_].name == "PointData") data = at_;
    }
    if (points == 0) return Wrong("has a Piece without Points");
    LATTICED_RETURN_IF_ERROR(ReadPoints(points));
    const size_t count = parts_.points.size() - before;
    uint64_t announced = count;
    const std::string_view number = tags_[piece].Value("NumberOfPoints");
    if (!number.empty() &&
        (!absl::SimpleAtoi(absl::string_view(number.data(), number.size()), &announced) ||
         announced != count)) {
      return Wrong(fmt::format("has {} points in a Piece of '{}'", count, number));
    }
    return AddDisplacement(data, points, before, count);
  }

  absl::Status ReadPoints(size_t points) {
    const size_t array = points + 1;
    if (array >= tags_.size() || tags_[array].name != "DataArray") {
      return Wrong("has Points without a DataArray");
    }
    const XmlTag& tag = tags_[array];
    size_t close = array;
    while (!tag.is_empty && tags_[close].name != "/DataArray") {
      if (++close >= tags_.size()) return Wrong("has a DataArray that does not end");
    }
    LATTICED_ASSIGN_OR_RETURN(const std::vector<double> numbers, NumbersOf(array));
    if (tag.Value("NumberOfComponents") != "3" || numbers.size() % 3 != 0) {
      return Wrong("its points have not three coordinates each");
    }
    const size_t before = parts_.points.size(), count = numbers.size() / 3;
    const std::vector<Vec3d> read = PointsFromNumbers(numbers);
    parts_.points.insert(parts_.points.end(), read.begin(), read.end());
    parts_.splices.push_back({.begin = tag.begin,
                              .end = tags_[close].end,
                              .before = kPointsHead,
                              .after = kArrayEnd,
                              .first_point = before,
                              .points = count});
    return absl::OkStatus();
  }

  absl::StatusOr<std::vector<double>> NumbersOf(size_t array) {
    const XmlTag& tag = tags_[array];
    const std::string_view type = tag.Value("type"), format = tag.Value("format");
    if (type != "Float32" && type != "Float64") {
      return Wrong(fmt::format("its points are of type {}; Float32 and Float64 are read", type));
    }
    const std::string_view inner = tag.is_empty || array + 1 >= tags_.size()
                                       ? std::string_view()
                                       : bytes_.substr(tag.end, tags_[array + 1].begin - tag.end);
    size_t at = 0;
    if (format == "ascii") return TextNumbers(inner, kAllNumbers, at);
    absl::StatusOr<std::string> data = format == "binary"     ? XmlArrayBytes(inner, true, coding_)
                                       : format == "appended" ? Appended(tag)
                                                              : Wrong("its points have no format");
    if (!data.ok()) return data.status();
    const bool is_float = type == "Float32";
    return BinaryNumbers(*data, data->size() / (is_float ? sizeof(float) : sizeof(double)),
                         is_float ? "float" : "double", coding_.order, at);
  }

  absl::StatusOr<std::string> Appended(const XmlTag& tag) {
    const XmlTag& last = tags_.back();
    const std::string_view offset = tag.Value("offset");
    uint64_t at = 0;
    const size_t mark = bytes_.find('_', last.end);
    if (last.name != "AppendedData" || mark == std::string_view::npos ||
        !absl::SimpleAtoi(absl::string_view(offset.data(), offset.size()), &at) ||
        at >= bytes_.size() - mark) {
      return Wrong("lacks the appended data of its points");
    }
    return XmlArrayBytes(bytes_.substr(mark + 1 + at), last.Value("encoding") == "base64", coding_);
  }

  // In PointData, or in one of its own in front of the points. Arguments are tags; data = 0: there is none. Some readers
  // know where an appended array ends by the next one alone, so appended points stay in the file, as "rest".
  absl::Status AddDisplacement(size_t data, size_t points, size_t first, size_t count) {
    const XmlTag& array = tags_[points + 1];
    VtkSplice moves{.before = kMovesHead,
                    .after = kArrayEnd,
                    .what = VtkSplice::What::kMoves,
                    .first_point = first,
                    .points = count};
    if (array.Value("format") == "appended") {
      moves.rest = fmt::format(
          "<DataArray type=\"{}\" Name=\"rest\" NumberOfComponents=\"3\" format=\"appended\" "
          "offset=\"{}\"/>",
          array.Value("type"), array.Value("offset"));
    }
    moves.begin = moves.end = data == 0 ? tags_[points].begin : tags_[data].end;
    if (data == 0) {
      moves.before = std::string("<PointData>") + kMovesHead;
      moves.closing = "</PointData>\n";
    } else if (tags_[data].is_empty) {
      const XmlTag& tag = tags_[data];
      moves.begin = tag.begin;
      moves.before = fmt::format("<PointData{}>{}", tag.attributes, kMovesHead);
      moves.closing = "</PointData>";
    } else {
      for (size_t n = data; n < tags_.size() && tags_[n].name != "/PointData"; ++n) {
        if (tags_[n].Value("Name") == "displacement") return Wrong(kIsDeformed);
      }
    }
    parts_.splices.push_back(std::move(moves));
    return absl::OkStatus();
  }

  std::string_view bytes_;
  std::vector<XmlTag> tags_;
  XmlCoding coding_;
  XmlVtk parts_;
  size_t at_ = 0;
};

}  // namespace

absl::StatusOr<XmlVtk> ParseXmlVtk(std::string_view bytes) { return XmlVtkParser(bytes).Parse(); }

}  // namespace latticed::client
