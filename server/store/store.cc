// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What a store answers that has one server.
#include "server/store/store.h"

#include "core/base/status_macros.h"

namespace latticed {

absl::StatusOr<SceneClaim> Store::ClaimScene(std::string_view id) {
  LATTICED_RETURN_IF_ERROR(ReadSceneHeader(id).status());
  return SceneClaim();
}

absl::Status Store::ReleaseScene(std::string_view /*id*/) { return absl::OkStatus(); }

absl::Status Store::ExpireScene(std::string_view /*id*/, absl::Duration /*unused*/) {
  return absl::OkStatus();
}

void Store::OnFenced(std::function<void()> /*fenced*/) {}

absl::StatusOr<std::vector<StoredServer>> Store::Servers() { return std::vector<StoredServer>(); }

void Store::SetFreeBytes(uint64_t /*bytes*/) {}

}  // namespace latticed
