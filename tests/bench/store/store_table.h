// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// latticed_bench store: how long a record takes to be durable, from when its edit was due, in a store in a folder, in
// PostgreSQL by TCP on this machine, and with fdatasync of the same bytes alone, by turns; what the fence of PostgreSQL's
// appends adds; and how long a log takes to be read.
//
//   fdatasync alone   one thread appends all that waits to a file, calls fdatasync, and answers
//   written / logged  bytes that the process made the kernel write (/proc/self/io), with the checkpoint at the end,
//                     divided by bytes of records
//
// Folders are made in $TMPDIR, or /tmp. After each run the store is opened again, and all its records are compared.
#ifndef LATTICED_TESTS_BENCH_STORE_STORE_TABLE_H_
#define LATTICED_TESTS_BENCH_STORE_STORE_TABLE_H_

#include <vector>

#include "tests/bench/report/report.h"

namespace latticed::bench {

[[nodiscard]] std::vector<Section> StoreTables();

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_STORE_STORE_TABLE_H_
