// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The rows of shares. Each is written by the server that its scene belongs to, or by any other: nothing depends on it.
//
// Errors   as connection.h; kNotFound
// Threads  safe
#ifndef LATTICED_SERVER_STORE_POSTGRES_SHARE_ROWS_H_
#define LATTICED_SERVER_STORE_POSTGRES_SHARE_ROWS_H_

#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/store/postgres/pool.h"

namespace latticed {

// kNotFound: there is no such scene.
[[nodiscard]] absl::Status PutPostgresShare(PgPool& pool, std::string_view id,
                                            std::string_view scene, std::string_view header);
// OK as well if there is none.
[[nodiscard]] absl::Status DeletePostgresShare(PgPool& pool, std::string_view id);
// Their count and the sum of their numbers. A last number in place of the sum would miss a share that is deleted while an
// older one, whose transaction took longer, appears.
[[nodiscard]] absl::StatusOr<std::string> ReadPostgresSharesMark(PgPool& pool);

}  // namespace latticed

#endif  // LATTICED_SERVER_STORE_POSTGRES_SHARE_ROWS_H_
