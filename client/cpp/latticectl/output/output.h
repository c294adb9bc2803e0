// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Output of commands. For programs (--json): JSON, with messages of the protocol as proto3 JSON, one
// document per command; `watch` prints one per update. For people: tables and numbers.
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_OUTPUT_OUTPUT_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_OUTPUT_OUTPUT_H_

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <ostream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "client/cpp/latticectl/output/console.h"
#include "client/cpp/library/latticed_client.h"
#include "google/protobuf/message.h"

namespace CLI {
class App;
}

namespace latticed::client {

void AddJsonFlag(CLI::App& command, bool& json);
void PrintJson(const nlohmann::json& json, std::ostream& out);
[[nodiscard]] std::string MessageJson(const google::protobuf::Message& message);
// Prints a command's result: as JSON if `as_json`, else the text.
void PrintResult(bool as_json, const nlohmann::json& json, std::string_view text,
                 std::ostream& out);
void PrintResult(bool as_json, const google::protobuf::Message& message, std::string_view text,
                 std::ostream& out);

template <typename Message>
void PrintJsonArray(const std::vector<Message>& messages, std::ostream& out) {
  out << '[';
  for (size_t i = 0; i < messages.size(); ++i) {
    out << (i == 0 ? "\n" : ",\n") << MessageJson(messages[i]);
  }
  out << "]\n";
}

// A table: each column has the width of its widest cell; two spaces separate columns. An empty header
// prints no head line.
class TextTable {
 public:
  explicit TextTable(std::vector<std::string> header = {}) : header_(std::move(header)) {}
  void AddRow(std::vector<std::string> row) { rows_.push_back(std::move(row)); }
  [[nodiscard]] std::string Text() const;

 private:
  std::vector<std::string> header_;
  std::vector<std::vector<std::string>> rows_;
};

[[nodiscard]] std::string FormatBytes(uint64_t bytes);  // "1.50 MiB"
[[nodiscard]] std::string FormatCount(uint64_t count);  // "1,129,920"
// "1 scene", "1,200 scenes"; `more` is the plural where that is not `one` and an s.
[[nodiscard]] std::string Counted(uint64_t count, std::string_view one, std::string_view more = "");
[[nodiscard]] std::string FormatMilliseconds(double milliseconds);  // "12.3 ms"

// A line that is shown only on a terminal, and replaced by the next one.
class StatusLine {
 public:
  explicit StatusLine(Console console) : console_(console) {}
  ~StatusLine();  // wipes the line
  StatusLine(const StatusLine&) = delete;
  StatusLine& operator=(const StatusLine&) = delete;

  void Show(std::string_view text);

 private:
  Console console_;
  bool shown_ = false;
};

// A progress bar of one line.
//
//   upload [##########          ]  50 %  1.00 MiB of 2.00 MiB
class ProgressBar {
 public:
  enum class Unit { kBytes, kCount, kNone };

  ProgressBar(Console console, std::string label, Unit unit);
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  void Show(uint64_t done, uint64_t total);
  // A Progress for the client's rpcs that calls Show. It must not outlive the bar.
  Progress callback();

 private:
  StatusLine line_;
  std::string label_;
  Unit unit_;
  int shown_percent_ = -1;
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_OUTPUT_OUTPUT_H_
