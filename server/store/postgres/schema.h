// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The tables and functions of the store, in the database's schema `latticed`.
//
//   version   number                                                       one row: the version of the schema
//   session   session, name, lease, expires, fenced, writer, free_bytes    a run of a server: lease.h
//   scene     number, id, session, snapshot_lsn, sum, header               session: its owner, or NULL
//   snapshot  scene, lsn, sum, bytes                                       the last one
//   record    scene, lsn, sum, bytes                                       the log
//   mesh      id, sum, header                                              the bytes are not in the database
//   share     id, number, scene, sum, header                               goes with its scene; number: the order of making
//
//   good_until(session)   when the lease of a session is over
//   attach(session)       a new connection of the writer: whoever had the old one writes nothing any more
//   claim(session, id)    claim.h
//   expire(session, id, unused)   deletes a scene that no server has had for so long
//
// Errors   kFailedPrecondition in one sentence: another program's schema, or a newer latticed's; else as connection.h
#ifndef LATTICED_SERVER_STORE_POSTGRES_SCHEMA_H_
#define LATTICED_SERVER_STORE_POSTGRES_SCHEMA_H_

#include "absl/status/status.h"
#include "server/store/postgres/connection.h"

namespace latticed {

inline constexpr int kPostgresSchemaVersion = 3;

// Makes the schema, or upgrades it from an older version, in one transaction. Servers that do so at once wait for each
// other.
[[nodiscard]] absl::Status PreparePostgresSchema(PgConnection& connection);

}  // namespace latticed

#endif  // LATTICED_SERVER_STORE_POSTGRES_SCHEMA_H_
