// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/output/output.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "fmt/format.h"
#include "google/protobuf/util/json_util.h"

namespace latticed::client {
namespace {

constexpr int kPercentPerMark = 4;
// Moves the cursor to the start of the line and erases the line.
constexpr char kWipe[] = "\r\x1b[K";

}  // namespace

void AddJsonFlag(CLI::App& command, bool& json) { command.add_flag("--json", json, "Print JSON"); }

void PrintJson(const nlohmann::json& json, std::ostream& out) { out << json.dump(2) << '\n'; }

std::string MessageJson(const google::protobuf::Message& message) {
  google::protobuf::util::JsonPrintOptions options;
  options.add_whitespace = true;
  options.always_print_primitive_fields = true;  // a coordinate of 0 is written as well
  std::string json;
  (void)google::protobuf::util::MessageToJsonString(message, &json, options);
  return json;
}

void PrintResult(bool as_json, const nlohmann::json& json, std::string_view text,
                 std::ostream& out) {
  if (as_json) {
    PrintJson(json, out);
  } else {
    out << text;
  }
}

void PrintResult(bool as_json, const google::protobuf::Message& message, std::string_view text,
                 std::ostream& out) {
  out << (as_json ? MessageJson(message) : text);
}

std::string TextTable::Text() const {
  std::vector<std::vector<std::string>> lines = rows_;
  if (!header_.empty()) lines.insert(lines.begin(), header_);
  std::vector<size_t> widths;
  for (const auto& line : lines) {
    widths.resize(std::max(widths.size(), line.size()));
    for (size_t c = 0; c < line.size(); ++c) widths[c] = std::max(widths[c], line[c].size());
  }
  std::string text;
  for (const auto& line : lines) {
    for (size_t c = 0; c < line.size(); ++c) {
      const bool last = c + 1 == line.size();
      text += last ? line[c] + '\n' : fmt::format("{:<{}}  ", line[c], widths[c]);
    }
  }
  return text;
}

std::string FormatBytes(uint64_t bytes) {
  static constexpr std::array<std::string_view, 5> kUnits{"B", "KiB", "MiB", "GiB", "TiB"};
  double value = static_cast<double>(bytes);
  size_t unit = 0;
  for (; value >= 1024 && unit + 1 < kUnits.size(); ++unit) value /= 1024;
  return unit == 0 ? fmt::format("{} B", bytes) : fmt::format("{:.2f} {}", value, kUnits[unit]);
}

std::string FormatCount(uint64_t count) {
  std::string digits = std::to_string(count);
  for (size_t at = digits.size(); at > 3;) {
    at -= 3;
    digits.insert(at, 1, ',');
  }
  return digits;
}

std::string Counted(uint64_t count, std::string_view one, std::string_view more) {
  const std::string number = FormatCount(count);
  if (count == 1) return fmt::format("{} {}", number, one);
  return more.empty() ? fmt::format("{} {}s", number, one) : fmt::format("{} {}", number, more);
}

std::string FormatMilliseconds(double milliseconds) {
  return fmt::format("{:.{}f} ms", milliseconds, milliseconds < 10 ? 2 : 1);
}

StatusLine::~StatusLine() {
  if (shown_) console_.err << kWipe << std::flush;
}

void StatusLine::Show(std::string_view text) {
  if (!console_.err_is_terminal) return;
  shown_ = true;
  console_.err << kWipe << text << std::flush;
}

ProgressBar::ProgressBar(Console console, std::string label, Unit unit)
    : line_(console), label_(std::move(label)), unit_(unit) {}

void ProgressBar::Show(uint64_t done, uint64_t total) {
  if (total == 0) return;
  const int percent = static_cast<int>(std::min(done, total) * 100 / total);
  if (percent == std::exchange(shown_percent_, percent)) return;
  std::string text = fmt::format("{} [{:<{}}] {:3} %", label_,
                                 std::string(static_cast<size_t>(percent / kPercentPerMark), '#'),
                                 100 / kPercentPerMark, percent);
  if (unit_ == Unit::kBytes)
    text += fmt::format("  {} of {}", FormatBytes(done), FormatBytes(total));
  if (unit_ == Unit::kCount)
    text += fmt::format("  {} of {}", FormatCount(done), FormatCount(total));
  line_.Show(text);
}

Progress ProgressBar::callback() {
  return [this](uint64_t done, uint64_t total) { Show(done, total); };
}

}  // namespace latticed::client
