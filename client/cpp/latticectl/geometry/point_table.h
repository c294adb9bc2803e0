// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Tables of numbers in files: for 'latticectl points' rows of x y z, or of x y z and a normal; for weights one column.
//
//   .csv  numbers separated by commas, a row per line; a first line without numbers is a heading. Written with the
//         shortest digits that give the same double
//   .npy  NumPy's format, versions 1 to 3: float64 or float32, little-endian, C order, one or two dimensions. Written in
//         version 1, float64
//
// Errors   kInvalidArgument in one sentence with the file's name, and the line of a CSV file; as files.h
// Threads  pure functions
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_GEOMETRY_POINT_TABLE_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_GEOMETRY_POINT_TABLE_H_

#include <cstddef>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace latticed::client {

struct PointTable {
  size_t columns = 3;
  std::vector<double> numbers;  // row by row

  size_t rows() const { return numbers.size() / columns; }
};

[[nodiscard]] absl::StatusOr<PointTable> ReadPointTable(const std::string& path);
[[nodiscard]] absl::Status WritePointTable(const std::string& path, const PointTable& table);

// The numbers of a table with one column, or of a .npy file with one dimension.
[[nodiscard]] absl::StatusOr<std::vector<double>> ReadColumn(const std::string& path);

// A check for CLI11: returns an error text unless the path ends in .csv or .npy.
[[nodiscard]] std::string CheckPointFileName(const std::string& path);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_GEOMETRY_POINT_TABLE_H_
