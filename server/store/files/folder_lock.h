// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// One server has a folder at a time. The lock is flock's on the file `lock`: it ends with the process, however that
// ends. The file also says whether the folder has been in use before.
//
// Errors   kFailedPrecondition: another server has it; kUnavailable, reason STORE: the file cannot be written
// Threads  safe
#ifndef LATTICED_SERVER_STORE_FILES_FOLDER_LOCK_H_
#define LATTICED_SERVER_STORE_FILES_FOLDER_LOCK_H_

#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace latticed {

class FolderLock {
 public:
  // Makes the folder if it is not there.
  [[nodiscard]] static absl::StatusOr<FolderLock> Take(const std::string& folder);
  FolderLock(FolderLock&& other) noexcept : file_(std::exchange(other.file_, -1)) {}
  FolderLock& operator=(FolderLock&&) = delete;
  ~FolderLock();

  // Whether MarkUsed was called, by this server or by one before.
  [[nodiscard]] bool used() const;
  // Durable when it returns OK.
  [[nodiscard]] absl::Status MarkUsed();

 private:
  explicit FolderLock(int file) : file_(file) {}

  int file_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_STORE_FILES_FOLDER_LOCK_H_
