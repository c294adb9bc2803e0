// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/progress_bar.h"

#include <algorithm>
#include <ostream>
#include <utility>

#include "client/cpp/latticectl/output.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

constexpr int kPercentPerMark = 4;
// Back to the begin of the line, and erase it.
constexpr char kWipe[] = "\r\x1b[K";

}  // namespace

ProgressBar::ProgressBar(Console console, std::string label, Unit unit)
    : console_(console), label_(std::move(label)), unit_(unit) {}

ProgressBar::~ProgressBar() {
  if (shown_percent_ >= 0) console_.err << kWipe << std::flush;
}

void ProgressBar::Show(uint64_t done, uint64_t total) {
  if (!console_.err_is_terminal || total == 0) return;
  const int percent = static_cast<int>(std::min(done, total) * 100 / total);
  if (percent == std::exchange(shown_percent_, percent)) return;
  std::string text = fmt::format("{} [{:<{}}] {:3} %", label_,
                                 std::string(static_cast<size_t>(percent / kPercentPerMark), '#'),
                                 100 / kPercentPerMark, percent);
  if (unit_ == Unit::kBytes)
    text += fmt::format("  {} of {}", FormatBytes(done), FormatBytes(total));
  if (unit_ == Unit::kCount)
    text += fmt::format("  {} of {}", FormatCount(done), FormatCount(total));
  console_.err << kWipe << text << std::flush;
}

Progress ProgressBar::callback() {
  return [this](uint64_t done, uint64_t total) { Show(done, total); };
}

}  // namespace latticed::client
