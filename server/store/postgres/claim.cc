// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/store/postgres/claim.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "absl/time/clock.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/store/store_errors.h"

namespace latticed {
namespace {

// How often the database is asked while a lease runs out, as a part of our own lease.
constexpr int kLooks = 16;
// A server's last run has no lease any more after one length of it.
constexpr int kMostLeases = 4;

constexpr char kClaim[] = "SELECT verdict, coalesce(owner, '') FROM latticed.claim($1, $2)";
constexpr char kExpired[] = "SELECT latticed.expire($1, $2, $3 * interval '1 us')::int::bigint";
constexpr char kServers[] =
    "SELECT name, free_bytes FROM latticed.session s "
    "WHERE latticed.good_until(s) > clock_timestamp() ORDER BY name";

}  // namespace

absl::StatusOr<SceneClaim> ClaimPostgresScene(PgPool& pool, PgLease& lease, std::string_view id) {
  const absl::Time end = absl::Now() + kMostLeases * lease.length();
  while (true) {
    const int64_t session = lease.session();
    std::string verdict, owner;
    LATTICED_RETURN_IF_ERROR(pool.With([&](PgConnection& connection) -> absl::Status {
      LATTICED_ASSIGN_OR_RETURN(
          const PgRows rows, connection.Execute(kClaim, PgParameters().Number(session).Bytes(id)));
      verdict = rows.Bytes(0, 0);
      owner = rows.Bytes(0, 1);
      return absl::OkStatus();
    }));
    if (verdict == "missing") return error::NotFound("scene", id);
    if (verdict == "own") return SceneClaim();
    if (verdict == "fenced") {
      if (lease.WaitForNext(session) == session) {
        return error::StoreFailed("PostgreSQL: this server lost its lease");
      }
      continue;
    }
    // With our own name it is our last run, or our last lease.
    if (verdict == "other" && owner != lease.name()) return SceneClaim{std::move(owner)};
    if (absl::Now() > end) {
      return error::StoreFailed(
          fmt::format("PostgreSQL: another server advertises the name '{}' too", lease.name()));
    }
    absl::SleepFor(lease.length() / kLooks);
  }
}

absl::Status ExpirePostgresScene(PgPool& pool, const PgLease& lease, std::string_view id,
                                 absl::Duration unused) {
  return pool.With([&](PgConnection& connection) {
    return connection
        .Execute(kExpired, PgParameters()
                               .Number(lease.session())
                               .Bytes(id)
                               .Number(absl::ToInt64Microseconds(unused)))
        .status();
  });
}

absl::StatusOr<std::vector<StoredServer>> ReadPostgresServers(PgPool& pool) {
  std::vector<StoredServer> servers;
  LATTICED_RETURN_IF_ERROR(pool.With([&](PgConnection& connection) -> absl::Status {
    LATTICED_ASSIGN_OR_RETURN(const PgRows rows, connection.Execute(kServers, {}));
    servers.clear();
    for (int i = 0; i < rows.size(); ++i) {
      servers.push_back({std::string(rows.Bytes(i, 0)), static_cast<uint64_t>(rows.Number(i, 1))});
    }
    return absl::OkStatus();
  }));
  return servers;
}

}  // namespace latticed
