// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A file in memory, for a library that wants the path of a file.
//
// Threads  one at a time; others may read the path
#ifndef LATTICED_SERVER_NET_MEMORY_FILE_H_
#define LATTICED_SERVER_NET_MEMORY_FILE_H_

#include <string>
#include <string_view>

#include "absl/status/status.h"

namespace latticed {

class MemoryFile {
 public:
  MemoryFile() = default;
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  ~MemoryFile();

  // Replaces the content: who opens the path gets the old file or the new one, whole. kUnavailable if the system gives
  // no memory or no descriptor.
  [[nodiscard]] absl::Status Write(std::string_view content);
  // Valid in this process, after the first Write.
  [[nodiscard]] std::string path() const;

 private:
  int descriptor_ = -1;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_NET_MEMORY_FILE_H_
