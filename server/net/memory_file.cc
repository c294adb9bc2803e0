// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/net/memory_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "fmt/format.h"

namespace latticed {

MemoryFile::~MemoryFile() {
  if (descriptor_ >= 0) close(descriptor_);
}

absl::Status MemoryFile::Write(std::string_view content) {
  const auto failed = [] {
    return absl::UnavailableError(fmt::format("a file in memory: {}", std::strerror(errno)));
  };
  const int fresh = memfd_create("latticed", MFD_CLOEXEC);
  if (fresh < 0) return failed();
  const ssize_t written = write(fresh, content.data(), content.size());
  if (written != static_cast<ssize_t>(content.size())) {
    if (written >= 0) errno = ENOSPC;
    const absl::Status status = failed();
    close(fresh);
    return status;
  }
  if (descriptor_ < 0) {
    descriptor_ = fresh;
    return absl::OkStatus();
  }
  const bool replaced = dup3(fresh, descriptor_, O_CLOEXEC) >= 0;
  const absl::Status status = replaced ? absl::OkStatus() : failed();
  close(fresh);
  return status;
}

std::string MemoryFile::path() const { return fmt::format("/proc/self/fd/{}", descriptor_); }

}  // namespace latticed
