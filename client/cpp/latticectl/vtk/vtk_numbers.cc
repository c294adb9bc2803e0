// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/vtk/vtk_numbers.h"

#include <algorithm>
#include <cstring>

#include "absl/strings/ascii.h"
#include "absl/strings/numbers.h"
#include "absl/strings/string_view.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

bool IsSpace(char c) { return absl::ascii_isspace(static_cast<unsigned char>(c)); }

// Bytes of a number; 0: not known.
size_t SizeOfType(std::string_view type) {
  if (type.ends_with("char")) return 1;
  if (type.ends_with("short")) return 2;
  if (type == "float" || type == "int" || type == "unsigned_int") return 4;
  if (type == "double" || type.ends_with("long") || type == "vtktypeint64" || type == "vtkIdType") {
    return 8;
  }
  return 0;
}

// float and double count; others are only passed over.
double NumberOf(const char* bytes, size_t size, std::endian order) {
  char ordered[8] = {};
  std::copy(bytes, bytes + size, ordered);
  if (order != std::endian::native) std::reverse(ordered, ordered + size);
  if (size == sizeof(float)) {
    float number = 0;
    std::memcpy(&number, ordered, sizeof(number));
    return number;
  }
  double number = 0;
  if (size == sizeof(double)) std::memcpy(&number, ordered, sizeof(number));
  return number;
}

}  // namespace

absl::StatusOr<std::vector<double>> TextNumbers(std::string_view bytes, uint64_t count,
                                                size_t& at) {
  std::vector<double> numbers;
  while (numbers.size() < count) {
    while (at < bytes.size() && IsSpace(bytes[at])) ++at;
    const size_t begin = at;
    while (at < bytes.size() && !IsSpace(bytes[at])) ++at;
    if (begin == at && count == kAllNumbers) break;
    double number = 0;
    if (!absl::SimpleAtod(absl::string_view(bytes.data() + begin, at - begin), &number)) {
      return absl::InvalidArgumentError(
          begin == at ? fmt::format("ends after {} of {} numbers", numbers.size(), count)
                      : fmt::format("has '{}' in place of a number",
                                    bytes.substr(begin, std::min<size_t>(at - begin, 40))));
    }
    numbers.push_back(number);
  }
  return numbers;
}

absl::StatusOr<std::vector<double>> BinaryNumbers(std::string_view bytes, uint64_t count,
                                                  const std::string& type, std::endian order,
                                                  size_t& at) {
  const size_t size = SizeOfType(type);
  if (size == 0) return absl::InvalidArgumentError(fmt::format("has numbers of type {}", type));
  const uint64_t there = (bytes.size() - at) / size;
  if (there < count) {
    return absl::InvalidArgumentError(fmt::format("ends after {} of {} numbers", there, count));
  }
  std::vector<double> numbers(count);
  for (double& number : numbers) {
    number = NumberOf(bytes.data() + at, size, order);
    at += size;
  }
  return numbers;
}

std::vector<Vec3d> PointsFromNumbers(std::span<const double> numbers) {
  std::vector<Vec3d> points;
  points.reserve(numbers.size() / 3);
  for (size_t n = 0; n + 2 < numbers.size(); n += 3) {
    points.push_back({numbers[n], numbers[n + 1], numbers[n + 2]});
  }
  return points;
}

}  // namespace latticed::client
