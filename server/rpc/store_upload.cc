// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/store_upload.h"

#include "core/base/status_macros.h"
#include "server/rpc/server_env.h"
#include "server/stores/scene_registry.h"
#include "server/wire/mesh_header.h"

namespace latticed {
namespace {

// What a stored mesh's reply has beyond that of the mesh before: its time, and counts of scenes that
// may have come up since.
constexpr uint64_t kStillToCome = 256;

}  // namespace

absl::Status StoreUpload(ServerEnv& env, Upload& upload, const std::function<bool()>& cancelled,
                         ReplyRoom& room, v1::Mesh& reply) {
  const auto describe = [&env](const StoredMesh& mesh) {
    return ToProto(mesh, env.scenes->UseOfMesh(mesh.id), true);
  };
  LATTICED_ASSIGN_OR_RETURN(const auto mesh,
                            upload.Finish(env.meshes, cancelled, [&](const StoredMesh& made) {
                              return room.Hold(ReplyBytes(describe(made)) + kStillToCome);
                            }));
  reply = describe(*mesh);
  // More than was taken only where the mesh was there before, with labels of its own.
  return room.Hold(ReplyBytes(reply));
}

}  // namespace latticed
