// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/store/files/folder_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string_view>
#include <system_error>

#include "fmt/format.h"
#include "server/store/store_errors.h"

namespace latticed {
namespace {

constexpr std::string_view kMark = "latticed\n";

}  // namespace

absl::StatusOr<FolderLock> FolderLock::Take(const std::string& folder) {
  std::error_code failure;
  std::filesystem::create_directories(folder, failure);
  if (failure) return error::StoreFailed(fmt::format("{}: {}", folder, failure.message()));
  const std::string path = folder + "/lock";
  const int file = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, S_IRUSR | S_IWUSR);
  if (file < 0) return error::StoreFailed(fmt::format("{}: {}", path, std::strerror(errno)));
  FolderLock lock(file);
  if (flock(file, LOCK_EX | LOCK_NB) == 0) return lock;
  if (errno != EWOULDBLOCK) {
    return error::StoreFailed(fmt::format("{}: {}", path, std::strerror(errno)));
  }
  return absl::FailedPreconditionError(
      fmt::format("{} is in use by another server: stop it, or name another folder", folder));
}

FolderLock::~FolderLock() {
  if (file_ >= 0) close(file_);
}

bool FolderLock::used() const {
  struct stat found = {};
  return fstat(file_, &found) == 0 && found.st_size > 0;
}

absl::Status FolderLock::MarkUsed() {
  if (used()) return absl::OkStatus();
  const bool written =
      pwrite(file_, kMark.data(), kMark.size(), 0) == static_cast<ssize_t>(kMark.size());
  if (written && fsync(file_) == 0) return absl::OkStatus();
  return error::StoreFailed(fmt::format("lock: {}", std::strerror(errno)));
}

}  // namespace latticed
