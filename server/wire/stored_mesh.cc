// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/wire/stored_mesh.h"

#include <limits>
#include <utility>

#include "absl/strings/ascii.h"
#include "core/base/error.h"
#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "core/mesh/reading_memory.h"
#include "fmt/format.h"
#include "server/base/auth/tenant.h"
#include "server/engine/memory/allocation_limit.h"
#include "server/store/records/scene_log.pb.h"
#include "server/wire/mesh_header.h"

namespace latticed {
namespace {

constexpr size_t kHashBlockBytes = size_t{16} << 20;  // hashed between checks for cancellation

absl::StatusOr<std::string> Hash(std::string_view bytes, StopCheck stop) {
  Sha256 sha256;
  for (size_t at = 0; at < bytes.size(); at += kHashBlockBytes) {
    LATTICED_RETURN_IF_ERROR(stop());
    sha256.Update(bytes.substr(at, kHashBlockBytes));
  }
  return sha256.FinishHex();
}

absl::Status CheckSha256(const std::string& announced, const std::string& actual) {
  if (announced.empty() || absl::AsciiStrToLower(announced) == actual) return absl::OkStatus();
  return error::InvalidField("header.sha256",
                             fmt::format("announced {}, the bytes have {}", announced, actual),
                             "HASH_MISMATCH");
}

// Objects of libraries whose size does not depend on the file, not reserved; 4 MiB of them are a table of libdraco.
constexpr uint64_t kReadersBytes = uint64_t{16} << 20;

}  // namespace

absl::StatusOr<StoredMesh> ReadStoredMesh(UploadHeader header,
                                          std::shared_ptr<const std::string> bytes,
                                          MemoryReservation& reservation, StopCheck stop) {
  StoredMesh stored{std::move(header.mesh)};
  stored.bytes = std::move(bytes);
  LATTICED_ASSIGN_OR_RETURN(const std::string hash, Hash(*stored.bytes, stop));
  LATTICED_RETURN_IF_ERROR(CheckSha256(header.sha256, hash));
  stored.id = TenantKey(stored.tenant, hash);
  AllocationLimit limit(kReadersBytes);
  ReadingMemory memory([&, file = reservation.bytes()](uint64_t bytes) -> absl::Status {
    const AllocationLimit::Pause pause;
    LATTICED_RETURN_IF_ERROR(reservation.Resize("reading the mesh", file + bytes));
    limit.Raise(bytes + kReadersBytes);
    return absl::OkStatus();
  });
  LATTICED_ASSIGN_OR_RETURN(PolygonMesh mesh, ReadUpload(stored, *stored.bytes, &memory));
  LATTICED_RETURN_IF_ERROR(stop());
  stored.bounds = mesh.ComputeBounds();
  stored.mesh = std::make_shared<const PolygonMesh>(std::move(mesh));
  return stored;
}

std::string StoredHeaderOf(const StoredMesh& mesh) {
  store::MeshHeader stored;
  stored.set_header(HeaderOf(mesh).SerializeAsString());
  stored.set_owner(mesh.owner);
  stored.set_tenant(mesh.tenant);
  stored.set_create_time(absl::ToUnixNanos(mesh.create_time));
  v1::Mesh listing = ToProto(mesh, {}, false);
  listing.clear_host_bytes();
  stored.set_listing(listing.SerializeAsString());
  return stored.SerializeAsString();
}

absl::StatusOr<v1::Mesh> ListedFromStored(std::string_view header) {
  store::MeshHeader stored;
  v1::Mesh listing;
  if (!stored.ParseFromArray(header.data(), static_cast<int>(header.size())) ||
      stored.listing().empty() || !listing.ParseFromString(stored.listing())) {
    return absl::DataLossError("the header has nothing that lists show");
  }
  return listing;
}

absl::StatusOr<StoredMesh> MeshFromStored(std::string_view header,
                                          std::shared_ptr<const std::string> bytes,
                                          MemoryReservation& reservation) {
  store::MeshHeader stored;
  v1::MeshHeader announced;
  if (!stored.ParseFromArray(header.data(), static_cast<int>(header.size())) ||
      !announced.ParseFromString(stored.header())) {
    return absl::DataLossError("the header of the mesh cannot be read");
  }
  LATTICED_ASSIGN_OR_RETURN(UploadHeader upload,
                            FromProto(announced, std::numeric_limits<uint64_t>::max()));
  upload.mesh.owner = stored.owner();
  upload.mesh.tenant = stored.tenant();
  LATTICED_ASSIGN_OR_RETURN(
      auto mesh, ReadStoredMesh(std::move(upload), std::move(bytes), reservation, NeverStop));
  mesh.create_time = absl::FromUnixNanos(stored.create_time());
  return mesh;
}

absl::StatusOr<std::string> HeaderForTenant(std::string_view header, const std::string& tenant) {
  store::MeshHeader stored;
  if (!stored.ParseFromArray(header.data(), static_cast<int>(header.size()))) {
    return absl::DataLossError("the header of the mesh cannot be read");
  }
  stored.set_tenant(tenant);
  return stored.SerializeAsString();
}

}  // namespace latticed
