// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How long the log of a scene takes to become its history again: 100,000 edits of 10 of 8 x 8 x 8 control points, without a
// snapshot, in a folder with nine other scenes of as many.
#ifndef LATTICED_TESTS_BENCH_STORE_REPLAY_TABLE_H_
#define LATTICED_TESTS_BENCH_STORE_REPLAY_TABLE_H_

#include "tests/bench/report/report.h"

namespace latticed::bench {

[[nodiscard]] Section ReplayTable();

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_STORE_REPLAY_TABLE_H_
