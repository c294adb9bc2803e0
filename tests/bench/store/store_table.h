// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// latticed_bench store [PART]: what it costs that edits survive a crash. All parts, or one:
//
//   writes    how long a record takes to be durable, from when its edit was due, in a store in a folder, in PostgreSQL by
//             TCP on this machine, and with fdatasync of the same bytes alone, by turns; what the fence of PostgreSQL's
//             appends adds
//   edits     what durability adds from an edit to the last byte of its update (edit_table.h)
//   replay    how long a long log takes to be read and replayed, without a snapshot
//   restart   a server that starts on 100 scenes with long logs (restart_table.h); makes them in a minute or two
//
//   fdatasync alone   one thread appends all that waits to a file, calls fdatasync, and answers
//   written / logged  bytes that the process made the kernel write (/proc/self/io), with the checkpoint at the end,
//                     divided by bytes of records
//
// Folders are made in $TMPDIR, or /tmp. After each run of `writes` the store is opened again, and all its records are
// compared.
#ifndef LATTICED_TESTS_BENCH_STORE_STORE_TABLE_H_
#define LATTICED_TESTS_BENCH_STORE_STORE_TABLE_H_

#include <string_view>
#include <vector>

#include "tests/bench/report/report.h"

namespace latticed::bench {

// Whether there is such a part, one of those above.
[[nodiscard]] bool IsStorePart(std::string_view part);
// The tables of one part, or of all if `part` is empty.
[[nodiscard]] std::vector<Section> StoreTables(std::string_view part);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_STORE_STORE_TABLE_H_
