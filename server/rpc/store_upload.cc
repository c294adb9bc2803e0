// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/store_upload.h"

#include <utility>

#include "absl/strings/ascii.h"
#include "core/base/error.h"
#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/rpc/server_env.h"
#include "server/stores/scene_registry.h"
#include "server/wire/mesh_header.h"

namespace latticed {
namespace {

// What a stored mesh's reply has beyond that of the mesh before: its time, and counts of scenes that
// may have come up since.
constexpr uint64_t kStillToCome = 256;
constexpr size_t kHashBlockBytes = size_t{16} << 20;  // between looks at `cancelled`

absl::Status Cancelled() { return absl::CancelledError("the caller cancelled the upload"); }

absl::StatusOr<std::string> Hash(std::string_view bytes, const std::function<bool()>& cancelled) {
  Sha256 sha256;
  for (size_t at = 0; at < bytes.size(); at += kHashBlockBytes) {
    if (cancelled()) return Cancelled();
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

// The mesh of the bytes, all but its memory and time.
absl::StatusOr<StoredMesh> Read(UploadHeader header, std::shared_ptr<const std::string> bytes,
                                const std::function<bool()>& cancelled) {
  StoredMesh stored{std::move(header.mesh)};
  stored.bytes = std::move(bytes);
  LATTICED_ASSIGN_OR_RETURN(stored.id, Hash(*stored.bytes, cancelled));
  LATTICED_RETURN_IF_ERROR(CheckSha256(header.sha256, stored.id));
  LATTICED_ASSIGN_OR_RETURN(PolygonMesh mesh, ReadUpload(stored, *stored.bytes));
  if (cancelled()) return Cancelled();
  stored.bounds = mesh.ComputeBounds();
  stored.mesh = std::make_shared<const PolygonMesh>(std::move(mesh));
  return stored;
}

}  // namespace

absl::Status StoreUpload(ServerEnv& env, Upload& upload, const std::function<bool()>& cancelled,
                         ReplyRoom& room, v1::Mesh& reply) {
  const auto describe = [&env](const StoredMesh& mesh) {
    return ToProto(mesh, env.scenes->UseOfMesh(mesh.id), true);
  };
  LATTICED_ASSIGN_OR_RETURN(CompleteUpload complete, upload.Take());
  LATTICED_ASSIGN_OR_RETURN(StoredMesh made,
                            Read(std::move(complete.header), std::move(complete.bytes), cancelled));
  LATTICED_RETURN_IF_ERROR(room.Hold(ReplyBytes(describe(made)) + kStillToCome));
  LATTICED_ASSIGN_OR_RETURN(const auto mesh,
                            env.meshes.Add(std::move(made), std::move(complete.reservation)));
  reply = describe(*mesh);
  // More than was taken only where the mesh was there before, with labels of its own.
  return room.Hold(ReplyBytes(reply));
}

}  // namespace latticed
