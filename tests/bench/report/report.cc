// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/report/report.h"

#include <algorithm>
#include <ctime>
#include <fstream>
#include <string_view>
#include <thread>

#include "fmt/chrono.h"
#include "fmt/format.h"
#include "server/base/version.h"
#include "tests/bench/gpu/gpu.h"

namespace latticed::bench {
namespace {

std::string ProcessorName() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  }
  return "unknown processor";
}

std::string Escaped(std::string_view cell) {
  std::string text;
  for (const char c : cell) text += c == '|' ? std::string("\\|") : std::string(1, c);
  return text;
}

}  // namespace

std::string Machine() {
  const std::string host =
      fmt::format("{}, {} threads", ProcessorName(), std::thread::hardware_concurrency());
  const auto gpu = TheGpu();
  if (!gpu.ok()) return host;
  return fmt::format("{}; host {}", (*gpu)->backend().description(), host);
}

std::string ToText(const Section& section) {
  std::vector<size_t> widths(section.columns.size(), 0);
  const auto widen = [&](const std::vector<std::string>& cells) {
    for (size_t i = 0; i < cells.size(); ++i) widths[i] = std::max(widths[i], cells[i].size());
  };
  widen(section.columns);
  for (const auto& row : section.rows) widen(row);
  std::string text = fmt::format("\n{}\n", section.title);
  const auto add = [&](const std::vector<std::string>& cells) {
    for (size_t i = 0; i < cells.size(); ++i) {
      text += i == 0 ? fmt::format("{:<{}}", cells[i], widths[i])
                     : fmt::format("  {:>{}}", cells[i], widths[i]);
    }
    text += '\n';
  };
  add(section.columns);
  for (const auto& row : section.rows) add(row);
  for (const std::string& note : section.notes) text += fmt::format("  {}\n", note);
  return text;
}

std::string ToMarkdown(const Section& section) {
  std::string text = fmt::format("## {}\n\n", section.title);
  const auto add = [&](const std::vector<std::string>& cells) {
    for (const std::string& cell : cells) text += fmt::format("| {} ", Escaped(cell));
    text += "|\n";
  };
  add(section.columns);
  for (size_t i = 0; i < section.columns.size(); ++i) text += i == 0 ? "|---" : "|---:";
  text += "|\n";
  for (const auto& row : section.rows) add(row);
  text += '\n';
  for (const std::string& note : section.notes) text += fmt::format("* {}\n", note);
  if (!section.notes.empty()) text += '\n';
  return text;
}

absl::Status WriteMarkdown(const std::string& path, const std::string& command,
                           std::span<const Section> sections) {
  std::ofstream file(path);
  file << fmt::format("# latticed_bench, {:%Y-%m-%d}\n\n", fmt::localtime(std::time(nullptr)))
       << fmt::format("Commit {}. {}.\n\n```\n{}\n```\n\n", Commit(), Machine(), command);
  for (const Section& section : sections) file << ToMarkdown(section);
  file.close();
  if (file) return absl::OkStatus();
  return absl::InternalError(fmt::format("{} cannot be written", path));
}

}  // namespace latticed::bench
