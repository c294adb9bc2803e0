// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The bytes of meshes, one file each, named as server/store/objects/mesh_names.h says.
//
//   write to new-…   fsync   rename to the hash   fsync of the folder
//
// So a file with a hash for its name is whole, whenever the machine crashes. Names of other kinds are left alone.
//
// Open makes the folder if it is not there, and says if the file of a mesh that has a row is missing.
//
// Errors, threads  as MeshObjects
#ifndef LATTICED_SERVER_STORE_FILES_MESH_FOLDER_H_
#define LATTICED_SERVER_STORE_FILES_MESH_FOLDER_H_

#include <atomic>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "server/store/objects/mesh_objects.h"

namespace latticed {

class MeshFolder : public MeshObjects {
 public:
  // `writer` is in the names new-…: it tells servers apart that share the folder.
  explicit MeshFolder(std::string path, std::string writer = "")
      : path_(std::move(path)), writer_(std::move(writer)) {}

  absl::Status Open(const std::vector<std::string>& known, absl::Duration age) override;
  absl::StatusOr<std::string> Write(std::string_view id, std::string_view bytes) override;
  absl::Status Publish(const std::string& written, std::string_view id,
                       std::string_view bytes) override;
  void Discard(const std::string& written) override;
  absl::Status Remove(std::string_view id) override;
  absl::StatusOr<std::string> Read(std::string_view id) const override;

 private:
  std::string PathOf(std::string_view id) const;
  [[nodiscard]] absl::Status SyncFolder() const;

  const std::string path_;
  const std::string writer_;
  std::atomic<uint64_t> next_name_ = 0;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_STORE_FILES_MESH_FOLDER_H_
