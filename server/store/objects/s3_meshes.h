// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Meshes as objects of a bucket, under PREFIX and their names (mesh_names.h). The server is sent the hash of the bytes and
// refuses others; what is read must have it too.
//
//   Write     PUT under the hash: an object is there as a whole or not at all
//   Publish   HEAD: still there? Another server may have deleted the same mesh in between; then PUT again
//
// Listing a bucket would need a signed query, and a thousand meshes an answer. So Open reads and writes one object,
// "latticed-probe", and does not look for meshes that are missing, which Read tells, nor for objects without a row, which
// a crash or a failed delete leaves. Those cost only their space. server/store/README.md says how to find them.
//
// Threads  safe
#ifndef LATTICED_SERVER_STORE_OBJECTS_S3_MESHES_H_
#define LATTICED_SERVER_STORE_OBJECTS_S3_MESHES_H_

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/store/objects/mesh_objects.h"
#include "server/store/objects/s3_client.h"

namespace latticed {

class S3Meshes : public MeshObjects {
 public:
  explicit S3Meshes(S3Options options) : bucket_(std::move(options)) {}

  absl::Status Open(const std::vector<std::string>& known, absl::Duration age) override;
  absl::StatusOr<std::string> Write(std::string_view id, std::string_view bytes) override;
  absl::Status Publish(const std::string& written, std::string_view id,
                       std::string_view bytes) override;
  // The object stays: another server may have made a row for it.
  void Discard(const std::string& /*written*/) override {}
  absl::Status Remove(std::string_view id) override;
  absl::StatusOr<std::string> Read(std::string_view id) const override;

 private:
  mutable S3Client bucket_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_STORE_OBJECTS_S3_MESHES_H_
