// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Whether a file was written or replaced, also by the rename of a link above it, as Kubernetes replaces secrets.
//
// Threads  one at a time
#ifndef LATTICED_SERVER_BASE_WATCHED_FILE_H_
#define LATTICED_SERVER_BASE_WATCHED_FILE_H_

#include <sys/stat.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

namespace latticed {

class WatchedFile {
 public:
  // An empty path is a file that never changes.
  explicit WatchedFile(std::string path) : path_(std::move(path)) {}

  const std::string& path() const { return path_; }
  // Whether the file is another than at the last call; true at the first one. What is missing, or no file, has not
  // changed.
  [[nodiscard]] bool Changed() {
    const auto now = Look();
    if (!now.has_value() || now == last_) return false;
    last_ = now;
    return true;
  }

 private:
  using Identity = std::array<int64_t, 7>;
  std::optional<Identity> Look() const {
    struct stat file {};
    if (path_.empty() || stat(path_.c_str(), &file) != 0 || !S_ISREG(file.st_mode)) {
      return std::nullopt;
    }
    return Identity{
        static_cast<int64_t>(file.st_dev),          static_cast<int64_t>(file.st_ino),
        static_cast<int64_t>(file.st_size),         static_cast<int64_t>(file.st_mtim.tv_sec),
        static_cast<int64_t>(file.st_mtim.tv_nsec),
        static_cast<int64_t>(file.st_ctim.tv_sec),  // changes with its mode, too
        static_cast<int64_t>(file.st_ctim.tv_nsec)};
  }

  const std::string path_;
  std::optional<Identity> last_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_BASE_WATCHED_FILE_H_
