// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Tables and numbers for people.
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_TEXT_TABLE_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_TEXT_TABLE_H_

#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

namespace latticed::client {

// Columns as wide as their widest cell, two spaces apart. An empty header prints no head line.
class TextTable {
 public:
  explicit TextTable(std::vector<std::string> header = {}) : header_(std::move(header)) {}
  void AddRow(std::vector<std::string> row) { rows_.push_back(std::move(row)); }
  void Print(std::ostream& out) const;

 private:
  std::vector<std::string> header_;
  std::vector<std::vector<std::string>> rows_;
};

[[nodiscard]] std::string FormatBytes(uint64_t bytes);              // "1.50 MiB"
[[nodiscard]] std::string FormatCount(uint64_t count);              // "1,129,920"
[[nodiscard]] std::string FormatMilliseconds(double milliseconds);  // "12.3 ms"

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_TEXT_TABLE_H_
