// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Connections for whoever reads or claims, each used by one thread at a time.
//
// Threads  safe
#ifndef LATTICED_SERVER_STORE_POSTGRES_POOL_H_
#define LATTICED_SERVER_STORE_POSTGRES_POOL_H_

#include <string>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "core/base/mutex.h"
#include "server/store/postgres/connection.h"

namespace latticed {

class PgPool {
 public:
  static constexpr size_t kMostUnused = 8;

  explicit PgPool(std::string url) : url_(std::move(url)) {}

  // Calls `work` with a connection. If it was lost since it was used last, calls it once more with a new one: `work` is
  // such that this does no harm.
  [[nodiscard]] absl::Status With(absl::FunctionRef<absl::Status(PgConnection&)> work)
      ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  const std::string url_;
  Mutex mutex_;
  std::vector<PgConnection> unused_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace latticed

#endif  // LATTICED_SERVER_STORE_POSTGRES_POOL_H_
