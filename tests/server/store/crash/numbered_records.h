// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Scenes whose records follow from their numbers, so that whoever reads them knows whether they are the right ones.
#ifndef LATTICED_TESTS_SERVER_STORE_CRASH_NUMBERED_RECORDS_H_
#define LATTICED_TESTS_SERVER_STORE_CRASH_NUMBERED_RECORDS_H_

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "fmt/format.h"
#include "server/store/store.h"

namespace latticed::testing {

// 0 to 1,499 bytes; each tenth record is ten times as long, longer than a page.
inline std::string RecordOf(std::string_view scene, uint64_t lsn) {
  const std::string word = fmt::format("{}/{};", scene, lsn);
  const size_t size = (lsn * 7'919 + scene.size() * 101) % 1'500 * (lsn % 10 == 0 ? 10 : 1);
  std::string record;
  while (record.size() < size) record += word;
  record.resize(size);
  return record;
}

inline std::string SnapshotOf(std::string_view scene, uint64_t lsn) {
  return fmt::format("{} after {}, {}", scene, lsn, std::string(5'000, 's'));
}

inline std::string HeaderOf(std::string_view scene) { return fmt::format("header of {}", scene); }

// What is wrong with a scene; empty if nothing is.
inline std::string WrongIn(const SceneLog& log, std::string_view scene) {
  if (log.header != HeaderOf(scene)) return fmt::format("{}: wrong header", scene);
  if (log.snapshot_lsn > 0 && log.snapshot != SnapshotOf(scene, log.snapshot_lsn)) {
    return fmt::format("{}: wrong snapshot {}", scene, log.snapshot_lsn);
  }
  uint64_t lsn = log.snapshot_lsn;
  for (const std::string& record : log.records) {
    if (record != RecordOf(scene, ++lsn)) return fmt::format("{}: wrong record {}", scene, lsn);
  }
  return "";
}

// How many faults of `all` a test makes: a tenth, or what LATTICED_STORE_FAULTS says, in tenths.
inline int Faults(int all) {
  const char* tenths = std::getenv("LATTICED_STORE_FAULTS");
  return all / 10 * (tenths == nullptr ? 1 : std::atoi(tenths));
}

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_STORE_CRASH_NUMBERED_RECORDS_H_
