// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How long a server takes to be ready on a folder of 100 scenes, each with 100,000 edits, after a SIGKILL; and one of the
// scenes, of 5,760 faces, from the first call about it to all bytes of its surface.
//
// A server makes the scenes. Their edits are appended to its store one by one, with a snapshot every 4,096, as it does.
// Scenes that come back are compared with the history that made the records, and their surfaces with the definition.
#ifndef LATTICED_TESTS_BENCH_STORE_RESTART_TABLE_H_
#define LATTICED_TESTS_BENCH_STORE_RESTART_TABLE_H_

#include "tests/bench/report/report.h"

namespace latticed::bench {

[[nodiscard]] Section RestartTable();

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_STORE_RESTART_TABLE_H_
