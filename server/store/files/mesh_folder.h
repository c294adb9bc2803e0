// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The bytes of meshes, one file each, named by their SHA-256.
//
//   write to new-…   fsync   rename to the hash   fsync of the folder
//
// So a file with a hash for its name is whole, whenever the machine crashes. Names of other kinds are left alone.
//
// Errors   kResourceExhausted or kUnavailable, reason STORE; kDataLoss naming the mesh
// Threads  safe; the caller sees to it that one mesh is not published and removed at once
#ifndef LATTICED_SERVER_STORE_FILES_MESH_FOLDER_H_
#define LATTICED_SERVER_STORE_FILES_MESH_FOLDER_H_

#include <atomic>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"

namespace latticed {

class MeshFolder {
 public:
  // `writer` is in the names new-…: it tells servers apart that share the folder.
  explicit MeshFolder(std::string path, std::string writer = "")
      : path_(std::move(path)), writer_(std::move(writer)) {}

  // Makes the folder if it is not there, and removes what a crash left: files of which nobody knows, that is all but
  // those of `known`, if they were not written within `age`. kDataLoss if one of `known` is missing.
  [[nodiscard]] absl::Status Open(const std::vector<std::string>& known,
                                  absl::Duration age = absl::ZeroDuration());

  // Writes the bytes under a name of their own, which it returns.
  [[nodiscard]] absl::StatusOr<std::string> Write(std::string_view bytes);
  // Gives a file of Write its name. Durable when it returns OK.
  [[nodiscard]] absl::Status Publish(const std::string& written, std::string_view id);
  void Discard(const std::string& written);
  [[nodiscard]] absl::Status Remove(std::string_view id);
  [[nodiscard]] absl::StatusOr<std::string> Read(std::string_view id) const;

 private:
  std::string PathOf(std::string_view id) const;
  [[nodiscard]] absl::Status SyncFolder() const;

  const std::string path_;
  const std::string writer_;
  std::atomic<uint64_t> next_name_ = 0;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_STORE_FILES_MESH_FOLDER_H_
