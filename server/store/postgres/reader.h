// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Reads scenes, on the caller's thread, beside the writer.
//
// Errors   kNotFound; kAborted where the scene is not this session's; kDataLoss naming scene and record; else as connection.h
// Threads  safe
#ifndef LATTICED_SERVER_STORE_POSTGRES_READER_H_
#define LATTICED_SERVER_STORE_POSTGRES_READER_H_

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "server/store/postgres/pool.h"
#include "server/store/postgres/tails.h"
#include "server/store/store.h"

namespace latticed {

struct PgScene {
  SceneLog log;
  PgTail tail;
};

// `session` must own it, if one is given.
[[nodiscard]] absl::StatusOr<PgScene> ReadPostgresScene(PgPool& pool,
                                                        std::optional<int64_t> session,
                                                        std::string_view id);
// Rows of table `scene` or `mesh`, in order of id: all, or that with `*id`. `kind` names one of them.
[[nodiscard]] absl::StatusOr<std::vector<StoredEntry>> ReadPostgresEntries(
    PgPool& pool, std::string_view kind, const std::string_view* id = nullptr);
// The header of one.
[[nodiscard]] absl::StatusOr<std::string> ReadPostgresHeader(PgPool& pool, std::string_view kind,
                                                             std::string_view id);

}  // namespace latticed

#endif  // LATTICED_SERVER_STORE_POSTGRES_READER_H_
