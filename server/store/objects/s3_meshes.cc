// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/store/objects/s3_meshes.h"

#include <algorithm>
#include <utility>

#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/base/auth/tenant.h"
#include "server/store/objects/mesh_names.h"
#include "server/store/store_errors.h"

namespace latticed {
namespace {

constexpr std::string_view kProbe = "latticed-probe";
constexpr std::string_view kProbeBytes = "latticed keeps meshes here\n";
constexpr absl::Duration kMostStart =
    absl::Seconds(3);  // whoever starts it may have misspelt the endpoint

}  // namespace

absl::Status S3Meshes::Open(const std::vector<std::string>& /*known*/, absl::Duration /*age*/) {
  S3Options quick = bucket_.CurrentOptions();
  quick.most_time = std::min(quick.most_time, kMostStart);
  S3Client bucket(std::move(quick));
  absl::Status status = bucket.Put(kProbe, kProbeBytes, Sha256Hex(kProbeBytes));
  if (status.ok()) {
    const absl::StatusOr<std::string> bytes = bucket.Get(kProbe);
    status = bytes.status();
    if (bytes.ok() && *bytes != kProbeBytes)
      status = error::Damaged(kProbe, "S3 changed its bytes");
  }
  if (status.ok()) return status;
  return absl::Status(status.code(), fmt::format("{}: {}", bucket.CurrentOptions().Name(),
                                                 std::string(status.message())));
}

absl::StatusOr<std::string> S3Meshes::Write(std::string_view id, std::string_view bytes) {
  LATTICED_RETURN_IF_ERROR(bucket_.Put(MeshName(id), bytes, IdOf(id)));
  return std::string(id);
}

absl::Status S3Meshes::Publish(const std::string& /*written*/, std::string_view id,
                               std::string_view bytes) {
  const absl::StatusOr<uint64_t> there = bucket_.Head(MeshName(id));
  if (there.ok() && *there == bytes.size()) return absl::OkStatus();
  if (!there.ok() && !absl::IsNotFound(there.status())) return there.status();
  return bucket_.Put(MeshName(id), bytes, IdOf(id));
}

absl::Status S3Meshes::Remove(std::string_view id) { return bucket_.Delete(MeshName(id)); }

absl::StatusOr<std::string> S3Meshes::Read(std::string_view id) const {
  absl::StatusOr<std::string> bytes = bucket_.Get(MeshName(id));
  const std::string name = fmt::format("mesh {}", id);
  if (absl::IsNotFound(bytes.status())) return error::Damaged(name, "its object is missing");
  LATTICED_RETURN_IF_ERROR(bytes.status());
  if (Sha256Hex(*bytes) != IdOf(id)) return error::Damaged(name, "its bytes have another hash");
  return bytes;
}

}  // namespace latticed
