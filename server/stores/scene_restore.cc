// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Scenes of a SceneRegistry that are made from a copy.
#include <utility>

#include "absl/time/clock.h"
#include "core/base/catch_bad_alloc.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "server/base/auth/tenant.h"
#include "server/stores/scene_registry.h"

namespace latticed {

absl::Status SceneRegistry::Restore(SceneConfig config, SceneLog log,
                                    const std::function<absl::Status()>& admit, StopCheck stop,
                                    const Most& most) {
  const std::string id = config.id;
  const std::string mesh_id = config.mesh_id;
  const Sleeper sleeper{mesh_id, absl::Now() + config.idle_ttl, config.account};
  if (shared()) {  // another server may have made it
    const absl::Status found = options_.store->ReadSceneHeader(id).status();
    if (found.ok()) return error::AlreadyExists("scene", IdOf(id));
    if (!absl::IsNotFound(found)) return found;
  }
  {
    const MutexLock lock(&mutex_);
    LATTICED_RETURN_IF_ERROR(AwaitFree(id, stop));
    if (scenes_.contains(id) || asleep_.contains(id))
      return error::AlreadyExists("scene", IdOf(id));
    LATTICED_RETURN_IF_ERROR(CheckRoom(id, mesh_id, config.account, most));
    LATTICED_RETURN_IF_ERROR(admit());
    creating_[id] = {mesh_id, config.account};
  }
  Making making(this, id);
  LATTICED_ASSIGN_OR_RETURN(auto scene, Copied(std::move(config), std::move(log), stop));
  {
    const MutexLock lock(&mutex_);
    if (creating_[id].mesh_id == mesh_id) {
      if (scene != nullptr) scenes_[id] = std::move(scene);
      if (options_.store != nullptr && !shared()) asleep_[id] = sleeper;
      making.End();
      return absl::OkStatus();
    }
  }
  if (options_.store != nullptr) {
    LATTICED_RETURN_IF_ERROR(Claim(id));
    LATTICED_RETURN_IF_ERROR(options_.store->DeleteScene(id));
  }
  return error::NotFound("mesh", IdOf(mesh_id));
}

absl::StatusOr<std::shared_ptr<Scene>> SceneRegistry::Copied(SceneConfig config, SceneLog log,
                                                             StopCheck stop) {
  if (options_.store == nullptr) {
    return CatchBadAlloc("the scene",
                         [&] { return Scene::Restore(std::move(config), log, context(), stop); });
  }
  Store& store = *options_.store;
  LATTICED_RETURN_IF_ERROR(store.Admit());
  LATTICED_RETURN_IF_ERROR(log.snapshot_lsn == 0
                               ? store.CreateScene(config.id, std::move(log.header))
                               : store.CreateSceneAt(config.id, std::move(log.header),
                                                     log.snapshot_lsn, std::move(log.snapshot)));
  if (shared()) (void)store.ReleaseScene(config.id);  // the next call may be at any server
  return nullptr;
}

}  // namespace latticed
