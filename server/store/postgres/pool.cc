// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/store/postgres/pool.h"

#include <optional>

#include "core/base/status_macros.h"

namespace latticed {

absl::Status PgPool::With(absl::FunctionRef<absl::Status(PgConnection&)> work) {
  std::optional<PgConnection> connection;
  {
    MutexLock lock(&mutex_);
    if (!unused_.empty()) {
      connection = std::move(unused_.back());
      unused_.pop_back();
    }
  }
  if (connection.has_value()) {
    const absl::Status status = work(*connection);
    if (connection->lost()) {
      connection.reset();
      MutexLock lock(&mutex_);
      unused_.clear();  // most likely they are lost too
    } else {
      MutexLock lock(&mutex_);
      if (unused_.size() < kMostUnused) unused_.push_back(*std::move(connection));
      return status;
    }
  }
  LATTICED_ASSIGN_OR_RETURN(PgConnection fresh, PgConnection::Open(url_));
  const absl::Status status = work(fresh);
  MutexLock lock(&mutex_);
  if (!fresh.lost() && unused_.size() < kMostUnused) unused_.push_back(std::move(fresh));
  return status;
}

}  // namespace latticed
