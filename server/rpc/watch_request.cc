// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/watch_request.h"

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/base/auth/tenant.h"
#include "server/engine/watch/view_tolerance.h"
#include "server/rpc/access/tenant_access.h"
#include "server/rpc/call.h"
#include "server/rpc/server_env.h"
#include "server/store/store_errors.h"
#include "server/stores/scene_registry.h"
#include "server/wire/converters.h"
#include "server/wire/presence_converters.h"
#include "server/wire/view_converters.h"

namespace latticed {
namespace {

constexpr int kDefaultUnackedUpdates = 2;

absl::StatusOr<WatchView> ViewOf(const v1::ViewOptions& options, const Scene& scene) {
  LATTICED_ASSIGN_OR_RETURN(const auto view,
                            WatchViewFromProto(options, scene.config().default_view, "view"));
  const RenderInput head = scene.Head();
  return SettleTolerance(view, *head.target, head.state->box, "view");
}

}  // namespace

absl::Status OrOnFreerServer(const ServerEnv& env, absl::Status refused) {
  const error::Details details = error::DetailsOf(refused);
  if (env.store == nullptr || !env.store->shared() || details.reason != "OUT_OF_MEMORY") {
    return refused;
  }
  const auto servers = env.store->Servers();
  if (!servers.ok() || servers->empty()) return refused;
  const auto& freest = *std::ranges::max_element(*servers, {}, &StoredServer::free_bytes);
  const uint64_t needed = std::max(details.asked_bytes, env.memory->free_bytes());
  if (freest.name == env.options.advertise || freest.free_bytes <= needed) return refused;
  return error::SceneMoved(freest.name);
}

absl::StatusOr<std::shared_ptr<Scene>> FindScene(const ServerEnv& env, const CallInfo& call,
                                                 const std::string& id) {
  if (id.empty()) return error::InvalidField("scene", "is required");
  LATTICED_RETURN_IF_ERROR(CheckSceneMetadata(call, id));
  const std::string key = KeyFor(call, id);
  const auto& shared = call.caller.shared;
  if (shared.has_value() && shared->scene != key) return error::NotFound("scene", id);
  auto scene = env.scenes->Find(key);
  const absl::Status found = OrOnFreerServer(env, ToldById(scene.status(), "scene", id));
  NoteOwner(env, call, found);
  LATTICED_RETURN_IF_ERROR(found);
  // Another server may have deleted the scene, and made one with its id, just now.
  if (shared.has_value() && shared->scene_create_time != (*scene)->create_time()) {
    return error::NotFound("scene", id);
  }
  return scene;
}

absl::StatusOr<OpenRequest> FromProto(ServerEnv* env, const CallInfo& call,
                                      const v1::WatchRequest& request) {
  LATTICED_ASSIGN_OR_RETURN(auto scene, FindScene(*env, call, request.scene()));
  LATTICED_ASSIGN_OR_RETURN(auto view, ViewOf(request.view(), *scene));
  if (request.editor_id().size() > limits::kMaxEditorIdBytes) {
    return error::InvalidField("editor_id",
                               fmt::format("at most {} bytes", limits::kMaxEditorIdBytes));
  }
  const int unacked =
      request.has_max_unacked_updates() ? request.max_unacked_updates() : kDefaultUnackedUpdates;
  if (unacked < 0 || unacked > limits::kMaxUnackedUpdates) {
    return error::OutOfRange("max_unacked_updates", unacked, 0, limits::kMaxUnackedUpdates);
  }
  OpenRequest open{.scene = std::move(scene)};
  open.options.watcher = {.editor_id = request.editor_id(),
                          .view = view,
                          .resume_token = request.resume_token(),
                          .max_unacked_updates = static_cast<size_t>(unacked)};
  return open;
}

absl::StatusOr<OpenRequest> FromProto(ServerEnv* env, const CallInfo& call,
                                      const v1::GetUpdateRequest& request) {
  LATTICED_ASSIGN_OR_RETURN(auto scene, FindScene(*env, call, request.scene()));
  LATTICED_ASSIGN_OR_RETURN(auto view, ViewOf(request.view(), *scene));
  const uint64_t revision = std::max(request.min_revision(), scene->State()->revision);
  OpenRequest open{.scene = std::move(scene)};
  open.options.watcher = {
      .view = view, .max_unacked_updates = 0, .min_revision = revision, .only_full_detail = true};
  open.options.only_update = revision;
  return open;
}

absl::StatusOr<WatchCommand> FromProto(const v1::ControlWatchRequest& request, const Scene& scene) {
  if (!request.scene().empty() && request.scene() != IdOf(scene.id())) {
    return error::InvalidField("scene", "is not the scene of the watch", "SCENE_MISMATCH");
  }
  WatchCommand command;
  if (request.has_acked_update_id()) command.acked_update_id = request.acked_update_id();
  if (request.has_pause()) command.pause = request.pause();
  if (request.has_view()) {
    LATTICED_ASSIGN_OR_RETURN(auto view, ViewOf(request.view(), scene));
    command.view = view;
  }
  if (request.has_presence()) {
    LATTICED_ASSIGN_OR_RETURN(command.presence, FromProto(request.presence()));
  }
  return command;
}

}  // namespace latticed
