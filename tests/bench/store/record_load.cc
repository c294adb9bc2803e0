// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/store/record_load.h"

#include <algorithm>
#include <fstream>
#include <vector>

#include "absl/time/clock.h"
#include "fmt/format.h"

namespace latticed::bench {
namespace {

uint64_t WrittenBytes() {
  std::ifstream io("/proc/self/io");
  for (std::string key; io >> key;) {
    uint64_t value = 0;
    io >> value;
    if (key == "write_bytes:") return value;
  }
  return 0;
}

}  // namespace

std::string LoadOfMachine() {
  std::ifstream file("/proc/loadavg");
  std::string minute;
  file >> minute;
  return minute;
}

std::string SceneId(int scene) { return fmt::format("scene {}", scene); }

std::string RecordOf(int scene, uint64_t lsn) {
  std::string record = fmt::format("{}, record {}: ", SceneId(scene), lsn);
  record.resize(kRecordBytes, 'x');
  return record;
}

Measured Drive(const Load& load, const Append& append, const std::function<void()>& end) {
  const uint64_t before = WrittenBytes();
  const auto scenes = static_cast<size_t>(load.scenes);
  std::vector<absl::Time> durable(load.edits());
  const absl::Duration apart = kRound / static_cast<int64_t>(load.edits());
  const absl::Time begin = absl::Now();
  const auto due = [&](size_t edit) { return begin + apart * static_cast<int64_t>(edit); };
  for (size_t edit = 0; edit < load.edits(); ++edit) {
    if (const absl::Duration early = due(edit) - absl::Now(); early > absl::ZeroDuration()) {
      absl::SleepFor(early);
    }
    append(static_cast<int>(edit % scenes), edit / scenes + 1,
           [&durable, edit] { durable[edit] = absl::Now(); });
  }
  end();
  std::vector<double> times;
  for (size_t edit = 0; edit < load.edits(); ++edit) {
    times.push_back(absl::ToDoubleMilliseconds(durable[edit] - due(edit)));
  }
  std::ranges::sort(times);
  const double logged = static_cast<double>(load.edits() * kRecordBytes);
  return {.p50 = times[times.size() / 2],
          .p99 = times[times.size() * 99 / 100],
          .written = static_cast<double>(WrittenBytes() - before) / logged};
}

}  // namespace latticed::bench
