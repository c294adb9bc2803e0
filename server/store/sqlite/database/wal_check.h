// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Finds damage in SQLite's write-ahead log, which SQLite itself takes for the log's end: it would drop all later
// commits and say nothing. The format is https://www.sqlite.org/fileformat2.html#walformat
//
//   header, 32 bytes | frame | frame | …     frame = page number, size of the database after a commit or 0, salt,
//                                                   checksum | page
//
// A crash cuts off one transaction: the frames of at most one commit are behind the last good one. Two or more with
// the salt of the header say that the medium has lost something in between. Damage in the last commit looks like a
// crash, and is not found.
//
// Errors   kDataLoss naming file and frame; kUnavailable, reason STORE, where the file cannot be read
// Threads  safe. While a server writes the log, what it is writing may look like damage
#ifndef LATTICED_SERVER_STORE_SQLITE_DATABASE_WAL_CHECK_H_
#define LATTICED_SERVER_STORE_SQLITE_DATABASE_WAL_CHECK_H_

#include <string>

#include "absl/status/status.h"

namespace latticed {

// OK where the file does not exist.
[[nodiscard]] absl::Status CheckWal(const std::string& path);

}  // namespace latticed

#endif  // LATTICED_SERVER_STORE_SQLITE_DATABASE_WAL_CHECK_H_
