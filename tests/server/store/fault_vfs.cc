// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/server/store/fault_vfs.h"

#include <sqlite3.h>

#include <atomic>
#include <map>
#include <mutex>

namespace latticed::testing {
namespace {

std::atomic<DiskFault> disk_fault = DiskFault::kNone;

// The methods of one kind of file, with faults, and without.
struct FaultyMethods {
  sqlite3_io_methods faulty;  // first: SQLite sees only this
  const sqlite3_io_methods* real;
};

const sqlite3_io_methods& Real(sqlite3_file* file) {
  return *reinterpret_cast<const FaultyMethods*>(file->pMethods)->real;
}

int Write(sqlite3_file* file, const void* from, int bytes, sqlite3_int64 offset) {
  switch (disk_fault.load()) {
    case DiskFault::kFull:
      return SQLITE_FULL;
    case DiskFault::kWriteFails:
      return SQLITE_IOERR_WRITE;
    default:
      return Real(file).xWrite(file, from, bytes, offset);
  }
}

int Sync(sqlite3_file* file, int flags) {
  disk_fault.wait(DiskFault::kStalls);
  if (disk_fault.load() == DiskFault::kSyncFails) return SQLITE_IOERR_FSYNC;
  return Real(file).xSync(file, flags);
}

// SQLite has one table of methods for files with locks, and one for those without.
const sqlite3_io_methods* WithFaults(const sqlite3_io_methods* real) {
  static std::mutex mutex;
  static std::map<const sqlite3_io_methods*, FaultyMethods> known;
  const std::lock_guard lock(mutex);
  const auto [found, is_new] = known.try_emplace(real, FaultyMethods{*real, real});
  if (is_new) {
    found->second.faulty.xWrite = Write;
    found->second.faulty.xSync = Sync;
  }
  return &found->second.faulty;
}

int Open(sqlite3_vfs* vfs, const char* name, sqlite3_file* file, int flags, int* out_flags) {
  auto* below = static_cast<sqlite3_vfs*>(vfs->pAppData);
  const int code = below->xOpen(below, name, file, flags, out_flags);
  if (code == SQLITE_OK) file->pMethods = WithFaults(file->pMethods);
  return code;
}

}  // namespace

void UseFaultVfs() {
  static const int registered = [] {
    sqlite3_vfs* real = sqlite3_vfs_find(nullptr);
    static sqlite3_vfs vfs = *real;
    vfs.pNext = nullptr;
    vfs.zName = "latticed-faults";
    vfs.pAppData = real;
    vfs.xOpen = Open;
    return sqlite3_vfs_register(&vfs, /*makeDflt=*/1);
  }();
  (void)registered;
}

void SetDiskFault(DiskFault fault) {
  disk_fault = fault;
  disk_fault.notify_all();
}

}  // namespace latticed::testing
