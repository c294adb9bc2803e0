// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/store/postgres/tails.h"

#include "core/base/status_macros.h"
#include "server/store/store_errors.h"

namespace latticed {

void PgTails::Forget(std::string_view id) {
  if (const auto found = scenes_.find(id); found != scenes_.end()) scenes_.erase(found);
}

const PgTail* PgTails::Find(std::string_view id) const {
  const auto found = scenes_.find(id);
  return found == scenes_.end() ? nullptr : &found->second.tail;
}

absl::StatusOr<int64_t> PgTails::Append(std::string_view id, uint64_t lsn) {
  LATTICED_RETURN_IF_ERROR(CheckSound(id));
  Scene& scene = scenes_.find(id)->second;
  const uint64_t next = scene.tail.lsn + 1;
  if (lsn != next) {
    scene.broken = error::NotNextRecord(id, next, lsn);
    return scene.broken;
  }
  scene.tail.lsn = lsn;
  return scene.tail.number;
}

absl::Status PgTails::CheckSound(std::string_view id) const {
  const auto found = scenes_.find(id);
  return found == scenes_.end() ? error::SceneNotOwned(id) : found->second.broken;
}

void PgTails::Break(std::string_view id, const absl::Status& why) {
  const auto found = scenes_.find(id);
  if (found != scenes_.end() && found->second.broken.ok()) found->second.broken = why;
}

}  // namespace latticed
