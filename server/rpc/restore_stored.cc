// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/restore_stored.h"

#include <string>
#include <utility>

#include "absl/time/clock.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/base/telemetry.h"
#include "server/rpc/server_env.h"
#include "server/stores/scene_registry.h"
#include "server/wire/stored_scene.h"

namespace latticed {
namespace {

void LogDamage(std::string_view what, const std::string& id, const absl::Status& status) {
  LogEvent(spdlog::level::err, "damaged in the store",
           {{std::string(what), id}, {"status", status.ToString()}});
}

absl::Status NameScene(ServerEnv& env, const StoredEntry& entry, absl::Time now) {
  // It cannot wake, but its id is taken, and it can be deleted.
  if (!entry.damage.ok()) env.scenes->AddAsleep(entry.id, "", absl::InfiniteFuture());
  LATTICED_RETURN_IF_ERROR(entry.damage);
  LATTICED_ASSIGN_OR_RETURN(const auto scene, StoredSceneOf(entry.header));
  env.scenes->AddAsleep(entry.id, scene.mesh_id, now + scene.idle_ttl);
  return absl::OkStatus();
}

}  // namespace

absl::Status RestoreStored(ServerEnv& env) {
  const absl::Time start = absl::Now();
  LATTICED_ASSIGN_OR_RETURN(const auto meshes, env.store->Meshes());
  for (const StoredEntry& entry : meshes) {
    if (!entry.damage.ok()) LogDamage("mesh", entry.id, entry.damage);
  }
  LATTICED_RETURN_IF_ERROR(env.shares.Read(start));
  if (env.store->shared()) return absl::OkStatus();  // other servers have scenes too
  LATTICED_ASSIGN_OR_RETURN(const auto scenes, env.store->Scenes());
  for (const StoredEntry& entry : scenes) {
    if (auto status = NameScene(env, entry, start); !status.ok())
      LogDamage("scene", entry.id, status);
  }
  LogEvent(spdlog::level::info, "restored from the store",
           {{"meshes", fmt::to_string(meshes.size())},
            {"scenes", fmt::to_string(scenes.size())},
            {"seconds", fmt::format("{:.2f}", absl::ToDoubleSeconds(absl::Now() - start))}});
  return absl::OkStatus();
}

}  // namespace latticed
