// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What a caller names by id is their tenant's: every id of a request becomes a key here.
//
// Threads  safe
#ifndef LATTICED_SERVER_RPC_ACCESS_TENANT_ACCESS_H_
#define LATTICED_SERVER_RPC_ACCESS_TENANT_ACCESS_H_

#include <memory>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace latticed {

struct CallInfo;    // server/rpc/call.h
struct ServerEnv;   // server/rpc/server_env.h
struct StoredMesh;  // server/stores/mesh_store.h

// The key (server/base/auth/tenant.h) of what the caller of `call` means by `id`.
[[nodiscard]] std::string KeyFor(const CallInfo& call, std::string_view id);
// The caller is told the id that they sent, whoever found nothing: kNotFound names no key of a store.
[[nodiscard]] absl::Status ToldById(const absl::Status& status, std::string_view kind,
                                    std::string_view id);
// A mesh of the caller's tenant; where they have the token of a share, of its scene. The errors of MeshStore::Find.
[[nodiscard]] absl::StatusOr<std::shared_ptr<const StoredMesh>> FindMesh(ServerEnv& env,
                                                                         const CallInfo& call,
                                                                         std::string_view id);

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_ACCESS_TENANT_ACCESS_H_
