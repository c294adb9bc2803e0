// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The files of SQLite on a disk that can be told to fail. UseFaultVfs makes it SQLite's default for the whole process,
// so call it before the first store is opened.
#ifndef LATTICED_TESTS_SERVER_STORE_FAULT_VFS_H_
#define LATTICED_TESTS_SERVER_STORE_FAULT_VFS_H_

namespace latticed::testing {

enum class DiskFault {
  kNone,
  kFull,        // writes fail: no room
  kWriteFails,  // writes fail: input/output error
  kSyncFails,   // writes succeed, and waiting for the medium fails
  kStalls,      // waiting for the medium takes until the fault changes
};

void UseFaultVfs();
// For all files from now on.
void SetDiskFault(DiskFault fault);

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_STORE_FAULT_VFS_H_
