// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// SQLite with a checksum in every page of the database. SQLite itself has checksums only in the write-ahead log: it
// would not notice a flipped bit that hides a row.
//
//   page   | 4,088 bytes of SQLite | XXH3-64 of them and of the page's offset, 8 bytes, little-endian |
//
// The last 8 bytes of each page are reserved by the header of the database (byte 20), so SQLite leaves them alone, and
// its other programs can read the file. They must not write it. A page that does not match, or that the file is too
// short for, is SQLITE_IOERR_DATA.
//
// Threads  safe
#ifndef LATTICED_SERVER_STORE_SQLITE_DATABASE_CHECKED_VFS_H_
#define LATTICED_SERVER_STORE_SQLITE_DATABASE_CHECKED_VFS_H_

#include "absl/status/statusor.h"

namespace latticed {

inline constexpr int kDatabasePageBytes = 4'096;
inline constexpr int kPageChecksumBytes = 8;

// The name for sqlite3_open_v2. The files are those of what was SQLite's default at the first call.
[[nodiscard]] absl::StatusOr<const char*> CheckedVfs();

}  // namespace latticed

#endif  // LATTICED_SERVER_STORE_SQLITE_DATABASE_CHECKED_VFS_H_
