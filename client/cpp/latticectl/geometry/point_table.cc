// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/geometry/point_table.h"

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <iterator>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_split.h"
#include "absl/strings/string_view.h"
#include "client/cpp/latticectl/geometry/files.h"
#include "core/base/read_file.h"
#include "core/base/status_macros.h"
#include "core/mesh/little_endian.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

constexpr absl::string_view kNpyMagic = "\x93NUMPY";
constexpr size_t kAlignment = 64;  // of the data in a .npy file

absl::Status Bad(const std::string& path, const std::string& problem) {
  return absl::InvalidArgumentError(fmt::format("{}: {}", path, problem));
}

std::string LowerExtension(const std::string& path) {
  return absl::AsciiStrToLower(std::filesystem::path(path).extension().string());
}

// False where a field is no number.
bool ReadRow(absl::string_view line, std::vector<double>& row) {
  row.clear();
  for (const absl::string_view field : absl::StrSplit(line, ',')) {
    double number = 0;
    if (!absl::SimpleAtod(absl::StripAsciiWhitespace(field), &number)) return false;
    row.push_back(number);
  }
  return true;
}

absl::StatusOr<PointTable> ReadCsv(const std::string& path, absl::string_view bytes) {
  PointTable table{.columns = 0};
  std::vector<double> row;
  size_t number = 0;
  for (const absl::string_view line : absl::StrSplit(bytes, '\n')) {
    ++number;
    if (absl::StripAsciiWhitespace(line).empty()) continue;
    if (!ReadRow(line, row)) {
      if (number == 1) continue;  // a heading
      return Bad(path, fmt::format("line {}: '{}' are no numbers separated by commas", number,
                                   std::string(line.substr(0, 60))));
    }
    if (table.columns == 0) table.columns = row.size();
    if (row.size() != table.columns) {
      return Bad(path, fmt::format("line {}: got {} numbers, the lines before have {}", number,
                                   row.size(), table.columns));
    }
    table.numbers.insert(table.numbers.end(), row.begin(), row.end());
  }
  return table;
}

std::string WriteCsv(const PointTable& table) {
  std::string text = table.columns == 6 ? "x,y,z,nx,ny,nz\n" : "x,y,z\n";
  for (size_t i = 0; i < table.numbers.size(); ++i) {
    const char end = (i + 1) % table.columns == 0 ? '\n' : ',';
    fmt::format_to(std::back_inserter(text), "{}{}", table.numbers[i], end);
  }
  return text;
}

// The value of a key in the dictionary of a .npy file, up to `end`; empty without the key.
absl::string_view ValueOf(absl::string_view header, absl::string_view key, absl::string_view begin,
                          char end) {
  size_t at = header.find(fmt::format("'{}':", std::string(key)));
  if (at == std::string::npos) return "";
  at = header.find(begin, at + key.size() + 3);
  if (at == std::string::npos) return "";
  const absl::string_view rest = header.substr(at + begin.size());
  return rest.substr(0, rest.find(end));
}

template <typename T>
void Append(absl::string_view data, std::vector<double>& numbers) {
  numbers.resize(data.size() / sizeof(T));
  for (size_t i = 0; i < numbers.size(); ++i) {
    numbers[i] = LoadLittleEndian<T>(data.data() + i * sizeof(T));
  }
}

absl::StatusOr<PointTable> ReadNpy(const std::string& path, absl::string_view bytes) {
  constexpr size_t kShortHead = 10,
                   kLongHead = 12;  // before the dictionary, in version 1 and later
  if (bytes.size() < kLongHead || !absl::StartsWith(bytes, kNpyMagic)) {
    return Bad(path, "is no .npy file");
  }
  const bool is_short = bytes[kNpyMagic.size()] == 1;
  const size_t head = is_short ? kShortHead : kLongHead;
  const size_t length = is_short ? LoadLittleEndian<uint16_t>(bytes.data() + kNpyMagic.size() + 2)
                                 : LoadLittleEndian<uint32_t>(bytes.data() + kNpyMagic.size() + 2);
  if (bytes.size() - head < length) return Bad(path, "ends in its header");
  const absl::string_view header = bytes.substr(head, length), data = bytes.substr(head + length);
  const absl::string_view type = ValueOf(header, "descr", "'", '\'');
  if (type != "<f8" && type != "<f4") {
    return Bad(path, fmt::format("has the type '{}'; '<f8' and '<f4' are read", std::string(type)));
  }
  if (!absl::StrContains(header, "'fortran_order': False")) {
    return Bad(path, "is not in C order; numpy.ascontiguousarray makes it so");
  }
  const std::vector<absl::string_view> shape =
      absl::StrSplit(ValueOf(header, "shape", "(", ')'), ',', absl::SkipWhitespace());
  uint64_t rows = 0, columns = 1;
  if (shape.empty() || shape.size() > 2 || !absl::SimpleAtoi(shape[0], &rows) ||
      (shape.size() == 2 && !absl::SimpleAtoi(shape[1], &columns)) || columns == 0 || columns > 6) {
    return Bad(path, "must have one or two dimensions, of rows and of at most 6 columns");
  }
  const size_t item = type == "<f8" ? sizeof(double) : sizeof(float);
  if (data.size() / item / columns != rows || data.size() % (item * columns) != 0) {
    return Bad(path, fmt::format("has {} bytes of numbers, not {} rows of {}", data.size(), rows,
                                 columns));
  }
  PointTable table{.columns = columns};
  item == sizeof(double) ? Append<double>(data, table.numbers) : Append<float>(data, table.numbers);
  return table;
}

std::string WriteNpy(const PointTable& table) {
  std::string header =
      fmt::format("{{'descr': '<f8', 'fortran_order': False, 'shape': ({}, {}), }}", table.rows(),
                  table.columns);
  constexpr size_t kHead = 10;
  const size_t used = kHead + header.size() + 1;
  header.append((kAlignment - used % kAlignment) % kAlignment, ' ');
  header += '\n';
  std::string bytes(kNpyMagic);
  bytes += '\x01';
  bytes += '\0';
  AppendLittleEndian(static_cast<uint16_t>(header.size()), &bytes);
  bytes += header;
  bytes.append(reinterpret_cast<const char*>(table.numbers.data()),
               table.numbers.size() * sizeof(double));
  return bytes;
}

absl::StatusOr<PointTable> ReadTable(const std::string& path) {
  LATTICED_ASSIGN_OR_RETURN(const std::string bytes, ReadFile(path));
  return LowerExtension(path) == ".npy" ? ReadNpy(path, bytes) : ReadCsv(path, bytes);
}

}  // namespace

absl::StatusOr<PointTable> ReadPointTable(const std::string& path) {
  LATTICED_ASSIGN_OR_RETURN(PointTable table, ReadTable(path));
  if (table.numbers.empty()) return Bad(path, "has no points");
  if (table.columns == 3 || table.columns == 6) return table;
  return Bad(path, fmt::format("has {} columns; 3, or 6 with normals, are needed", table.columns));
}

absl::StatusOr<std::vector<double>> ReadColumn(const std::string& path) {
  LATTICED_ASSIGN_OR_RETURN(PointTable table, ReadTable(path));
  if (table.numbers.empty()) return Bad(path, "has no numbers");
  if (table.columns == 1) return std::move(table.numbers);
  return Bad(path, fmt::format("has {} columns; one is needed", table.columns));
}

absl::Status WritePointTable(const std::string& path, const PointTable& table) {
  return WriteFile(path, LowerExtension(path) == ".npy" ? WriteNpy(table) : WriteCsv(table));
}

std::string CheckPointFileName(const std::string& path) {
  const std::string extension = LowerExtension(path);
  return extension == ".csv" || extension == ".npy"
             ? ""
             : fmt::format("{}: the extension must be .csv or .npy", path);
}

}  // namespace latticed::client
