// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Where the bytes of meshes are, each under its SHA-256: files of a folder (mesh_folder.h), or objects of a bucket
// (s3_meshes.h). Of a new mesh:
//
//   Write     the bytes, which may take long
//   Publish   they are there under the hash. Then the caller makes the mesh's row
//
// Errors   kResourceExhausted or kUnavailable, reason STORE; kDataLoss naming the mesh
// Threads  safe; the caller sees to it that one mesh is not published and removed at once
#ifndef LATTICED_SERVER_STORE_OBJECTS_MESH_OBJECTS_H_
#define LATTICED_SERVER_STORE_OBJECTS_MESH_OBJECTS_H_

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"

namespace latticed {

class MeshObjects {
 public:
  virtual ~MeshObjects() = default;

  // Before everything else: makes the place ready, or says in a sentence which place it is and why it cannot be used.
  // `known` are the meshes that have a row. What else is there, and was not written within `age`, was left by a crash and may
  // be removed.
  [[nodiscard]] virtual absl::Status Open(const std::vector<std::string>& known,
                                          absl::Duration age) = 0;

  // `bytes`, of which `id` is the hash, outlive Publish or Discard. Returns what those are given.
  [[nodiscard]] virtual absl::StatusOr<std::string> Write(std::string_view id,
                                                          std::string_view bytes) = 0;
  // Durable when it returns OK. May be called again: another server may have removed the bytes since, which is kUnavailable
  // if they cannot be published once more.
  [[nodiscard]] virtual absl::Status Publish(const std::string& written, std::string_view id,
                                             std::string_view bytes) = 0;
  // Instead of Publish, or after it has failed.
  virtual void Discard(const std::string& written) = 0;
  // OK as well if there are no bytes.
  [[nodiscard]] virtual absl::Status Remove(std::string_view id) = 0;
  // kDataLoss where they are missing or have another hash.
  [[nodiscard]] virtual absl::StatusOr<std::string> Read(std::string_view id) const = 0;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_STORE_OBJECTS_MESH_OBJECTS_H_
