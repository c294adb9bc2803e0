// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/store/sqlite/database/checked_vfs.h"

#include <sqlite3.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "server/store/store_errors.h"

namespace latticed {
namespace {

constexpr char kVfsName[] = "latticed-checked";
constexpr size_t kSummedBytes = kDatabasePageBytes - kPageChecksumBytes;

using Page = std::array<char, kDatabasePageBytes>;

// A file of the database. Behind it lies the file of the VFS below.
struct CheckedFile {
  sqlite3_file base;
};

sqlite3_file* Below(sqlite3_file* file) {
  return reinterpret_cast<sqlite3_file*>(reinterpret_cast<CheckedFile*>(file) + 1);
}

bool IsPage(int bytes, sqlite3_int64 offset) {
  return bytes == kDatabasePageBytes && offset % kDatabasePageBytes == 0;
}

uint64_t Checksum(const void* page, sqlite3_int64 offset) {
  return XXH3_64bits_withSeed(page, kSummedBytes, static_cast<XXH64_hash_t>(offset));
}

int Read(sqlite3_file* file, void* to, int bytes, sqlite3_int64 offset) {
  const int code = Below(file)->pMethods->xRead(Below(file), to, bytes, offset);
  if (!IsPage(bytes, offset)) return code;
  if (code == SQLITE_IOERR_SHORT_READ && offset > 0) return SQLITE_IOERR_DATA;
  if (code != SQLITE_OK) return code;
  uint64_t stored = 0;
  std::memcpy(&stored, static_cast<const char*>(to) + kSummedBytes, sizeof(stored));
  return stored == Checksum(to, offset) ? SQLITE_OK : SQLITE_IOERR_DATA;
}

int Write(sqlite3_file* file, const void* from, int bytes, sqlite3_int64 offset) {
  if (!IsPage(bytes, offset)) {
    return Below(file)->pMethods->xWrite(Below(file), from, bytes, offset);
  }
  Page page;
  std::memcpy(page.data(), from, page.size());
  const uint64_t sum = Checksum(from, offset);
  std::memcpy(page.data() + kSummedBytes, &sum, sizeof(sum));
  return Below(file)->pMethods->xWrite(Below(file), page.data(), bytes, offset);
}

// The rest goes to the file below as it is.
int Close(sqlite3_file* file) {
  const int code = Below(file)->pMethods->xClose(Below(file));
  file->pMethods = nullptr;
  return code;
}
int Truncate(sqlite3_file* file, sqlite3_int64 size) {
  return Below(file)->pMethods->xTruncate(Below(file), size);
}
int Sync(sqlite3_file* file, int flags) { return Below(file)->pMethods->xSync(Below(file), flags); }
int FileSize(sqlite3_file* file, sqlite3_int64* size) {
  return Below(file)->pMethods->xFileSize(Below(file), size);
}
int Lock(sqlite3_file* file, int lock) { return Below(file)->pMethods->xLock(Below(file), lock); }
int Unlock(sqlite3_file* file, int lock) {
  return Below(file)->pMethods->xUnlock(Below(file), lock);
}
int CheckReservedLock(sqlite3_file* file, int* result) {
  return Below(file)->pMethods->xCheckReservedLock(Below(file), result);
}
int FileControl(sqlite3_file* file, int operation, void* argument) {
  return Below(file)->pMethods->xFileControl(Below(file), operation, argument);
}
int SectorSize(sqlite3_file* file) { return Below(file)->pMethods->xSectorSize(Below(file)); }
int DeviceCharacteristics(sqlite3_file* file) {
  return Below(file)->pMethods->xDeviceCharacteristics(Below(file));
}
int ShmMap(sqlite3_file* file, int page, int bytes, int extend, void volatile** memory) {
  return Below(file)->pMethods->xShmMap(Below(file), page, bytes, extend, memory);
}
int ShmLock(sqlite3_file* file, int offset, int count, int flags) {
  return Below(file)->pMethods->xShmLock(Below(file), offset, count, flags);
}
void ShmBarrier(sqlite3_file* file) { Below(file)->pMethods->xShmBarrier(Below(file)); }
int ShmUnmap(sqlite3_file* file, int remove) {
  return Below(file)->pMethods->xShmUnmap(Below(file), remove);
}

// Version 2: with shared memory, without memory-mapped reading, which would go past the checks.
constexpr sqlite3_io_methods kMethods = {
    .iVersion = 2,
    .xClose = Close,
    .xRead = Read,
    .xWrite = Write,
    .xTruncate = Truncate,
    .xSync = Sync,
    .xFileSize = FileSize,
    .xLock = Lock,
    .xUnlock = Unlock,
    .xCheckReservedLock = CheckReservedLock,
    .xFileControl = FileControl,
    .xSectorSize = SectorSize,
    .xDeviceCharacteristics = DeviceCharacteristics,
    .xShmMap = ShmMap,
    .xShmLock = ShmLock,
    .xShmBarrier = ShmBarrier,
    .xShmUnmap = ShmUnmap,
};

// The functions that make, find and delete files are given the VFS that they belong to.
sqlite3_vfs* BelowVfs(sqlite3_vfs* vfs) { return static_cast<sqlite3_vfs*>(vfs->pAppData); }

int Open(sqlite3_vfs* vfs, const char* name, sqlite3_file* file, int flags, int* out_flags) {
  sqlite3_vfs* below = BelowVfs(vfs);
  if ((flags & SQLITE_OPEN_MAIN_DB) == 0) return below->xOpen(below, name, file, flags, out_flags);
  file->pMethods = nullptr;
  const int code = below->xOpen(below, name, Below(file), flags, out_flags);
  if (code == SQLITE_OK) file->pMethods = &kMethods;
  return code;
}
int Delete(sqlite3_vfs* vfs, const char* name, int sync_folder) {
  return BelowVfs(vfs)->xDelete(BelowVfs(vfs), name, sync_folder);
}
int Access(sqlite3_vfs* vfs, const char* name, int flags, int* result) {
  return BelowVfs(vfs)->xAccess(BelowVfs(vfs), name, flags, result);
}
int FullPathname(sqlite3_vfs* vfs, const char* name, int bytes, char* path) {
  return BelowVfs(vfs)->xFullPathname(BelowVfs(vfs), name, bytes, path);
}

// Registered for as long as the process lives.
int RegisterVfs() {
  sqlite3_vfs* below = sqlite3_vfs_find(nullptr);
  if (below == nullptr) return SQLITE_ERROR;
  static sqlite3_vfs vfs = *below;
  vfs.szOsFile = static_cast<int>(sizeof(CheckedFile)) + below->szOsFile;
  vfs.pNext = nullptr;
  vfs.zName = kVfsName;
  vfs.pAppData = below;
  vfs.xOpen = Open;
  vfs.xDelete = Delete;
  vfs.xAccess = Access;
  vfs.xFullPathname = FullPathname;
  return sqlite3_vfs_register(&vfs, /*makeDflt=*/0);
}

}  // namespace

absl::StatusOr<const char*> CheckedVfs() {
  static const int code = RegisterVfs();
  if (code != SQLITE_OK) return error::StoreFailed("SQLite has no files here");
  return kVfsName;
}

}  // namespace latticed
