// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Takes a scene over: function claim of schema.cc, called until it decides.
//
//   the owner's lease                  then
//   over, fenced, or nobody's          its row is locked, which waits for appends under way; it is fenced; the scene is ours
//   not renewed for half its length    wait
//   good                               its name
//   this server's own one is lost      wait for the next
//
// Errors   kNotFound; else as connection.h
#ifndef LATTICED_SERVER_STORE_POSTGRES_CLAIM_H_
#define LATTICED_SERVER_STORE_POSTGRES_CLAIM_H_

#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "server/store/postgres/lease.h"
#include "server/store/postgres/pool.h"
#include "server/store/store.h"

namespace latticed {

[[nodiscard]] absl::StatusOr<SceneClaim> ClaimPostgresScene(PgPool& pool, PgLease& lease,
                                                            std::string_view id);

// Deletes a scene that no server has had for `unused`. OK as well if a server has it.
[[nodiscard]] absl::Status ExpirePostgresScene(PgPool& pool, const PgLease& lease,
                                               std::string_view id, absl::Duration unused);

// In order of name. Those whose lease is good.
[[nodiscard]] absl::StatusOr<std::vector<StoredServer>> ReadPostgresServers(PgPool& pool);

}  // namespace latticed

#endif  // LATTICED_SERVER_STORE_POSTGRES_CLAIM_H_
