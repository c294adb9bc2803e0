// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What durability adds to an edit: the time from when a client sends it until it has the last byte of its update, with
// servers that keep scenes in memory, in a folder, and in PostgreSQL. They take turns, edit by edit, and fdatasync of the
// as many bytes as the edit's record has, about, takes one too. Each server evaluates on the CPU, and is in this process.
//
// Before the edits that are timed, a surface of each server is compared with the definition. After them, all servers have
// the same lattice, bit by bit, and the durable ones have it again after a restart.
#ifndef LATTICED_TESTS_BENCH_STORE_EDIT_TABLE_H_
#define LATTICED_TESTS_BENCH_STORE_EDIT_TABLE_H_

#include "tests/bench/report/report.h"
#include "tests/server/store/postgres_server.h"

namespace latticed::bench {

// `postgres` is null where it is not installed.
[[nodiscard]] Section EditTable(testing::PostgresServer* postgres);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_STORE_EDIT_TABLE_H_
