// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#ifndef LATTICED_TESTS_SERVER_STORE_CRASH_LOST_RECORDS_H_
#define LATTICED_TESTS_SERVER_STORE_CRASH_LOST_RECORDS_H_

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "gtest/gtest.h"
#include "server/store/store.h"
#include "tests/server/store/crash/numbered_records.h"

namespace latticed::testing {

// How many records and meshes of `acknowledged`, by what store_child.cc says, the store lacks. What is wrong is a failure.
inline uint64_t LostOf(const std::map<std::string, uint64_t>& acknowledged, Store& store) {
  constexpr std::string_view kMesh = "mesh/";
  uint64_t lost = 0;
  for (const auto& [name, lsn] : acknowledged) {
    if (name.starts_with(kMesh)) {
      if (!store.ReadMesh(name.substr(kMesh.size())).ok()) ++lost;
      continue;
    }
    const absl::StatusOr<SceneLog> log = store.ReadScene(name);
    EXPECT_EQ(log.ok() ? WrongIn(*log, name) : "", "");
    const uint64_t stored = log.ok() ? log->lsn() : 0;
    lost += stored < lsn ? lsn - stored : 0;
  }
  return lost;
}

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_STORE_CRASH_LOST_RECORDS_H_
