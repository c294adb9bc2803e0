// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A store that several servers share: scenes in a PostgreSQL database, meshes as files of a folder that all of them see or
// as objects of a bucket.
#ifndef LATTICED_SERVER_STORE_POSTGRES_STORE_H_
#define LATTICED_SERVER_STORE_POSTGRES_STORE_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "server/store/store.h"

namespace latticed {

struct PostgresStoreOptions {
  std::string url_file;     // holds the database's URL, which may have a password
  std::string mesh_store;   // a folder, which is made if it is not there; or s3://BUCKET/PREFIX
  std::string s3_endpoint;  // of the bucket (server/store/objects/s3_options.h)
  std::string s3_region;
  std::string name;  // that other servers tell clients
  absl::Duration lease = absl::Milliseconds(800);
  bool fence = true;  // false: for a test that must fail then
};

// Connects, makes the tables or upgrades them, and begins the lease.
//
// Errors   in one sentence without the password: kNotFound: no url_file; kInvalidArgument: it holds no URL, or
//          mesh_store is no bucket;
//          kFailedPrecondition: the tables are another program's or a newer latticed's; kDataLoss: the file of a mesh is
//          missing; kUnavailable and kResourceExhausted, reason STORE
[[nodiscard]] absl::StatusOr<std::unique_ptr<Store>> OpenPostgresStore(
    const PostgresStoreOptions& options);

}  // namespace latticed

#endif  // LATTICED_SERVER_STORE_POSTGRES_STORE_H_
