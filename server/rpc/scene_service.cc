// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/scene_service.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/numbers.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/base/labels.h"
#include "server/engine/surface_export.h"
#include "server/rpc/call.h"
#include "server/rpc/deform_stream.h"
#include "server/rpc/file_parts.h"
#include "server/rpc/get_update.h"
#include "server/rpc/part_stream.h"
#include "server/rpc/scene_service_base.h"
#include "server/rpc/server_env.h"
#include "server/rpc/topology.h"
#include "server/rpc/unary_call.h"
#include "server/rpc/watch_request.h"
#include "server/rpc/watch_stream.h"
#include "server/stores/scene_registry.h"
#include "server/wire/converters.h"
#include "server/wire/edit_converters.h"
#include "server/wire/scene_converters.h"
#include "server/wire/time_converters.h"

namespace latticed {
namespace {

using Clock = std::chrono::steady_clock;
using Context = grpc::CallbackServerContext;
using UnaryReactor = grpc::ServerUnaryReactor;

// Where a page of scenes, oldest first, begins: after the scene that this names.
struct PageKey {
  int64_t created = std::numeric_limits<int64_t>::min();  // Unix time, nanoseconds
  std::string id;
  friend auto operator<=>(const PageKey&, const PageKey&) = default;
};
PageKey KeyOf(const Scene& scene) { return {absl::ToUnixNanos(scene.create_time()), scene.id()}; }

std::string ToToken(const PageKey& key) { return fmt::format("{}.{}", key.created, key.id); }
absl::StatusOr<PageKey> FromToken(const std::string& token) {
  if (token.empty()) return PageKey{};
  const size_t dot = token.find('.');
  int64_t nanos = 0;
  if (dot == std::string::npos || !absl::SimpleAtoi(token.substr(0, dot), &nanos)) {
    return error::InvalidField("page_token", "is none that this server gave out");
  }
  return PageKey{nanos, token.substr(dot + 1)};
}

// The most that a new scene's reply takes: its labels may be large, the rest is not.
uint64_t SceneReplyBytes(const v1::CreateSceneRequest& request) {
  constexpr uint64_t kAllButLabels = 6 << 10;
  v1::Scene scene;
  *scene.mutable_labels() = request.labels();
  return kAllButLabels + ReplyBytes(scene);
}

class SceneServiceImpl final : public SceneServiceBase {
 public:
  explicit SceneServiceImpl(ServerEnv* env) : env_(env) {}

  UnaryReactor* CreateScene(Context* context, const v1::CreateSceneRequest* request,
                            v1::Scene* response) override {
    return RunUnary(env_, context, "SceneService/CreateScene", *request, response,
                    [=, this](const CallInfo& call, ReplyRoom& room) {
                      return Create(call, *request, room, response);
                    });
  }

  UnaryReactor* GetScene(Context* context, const v1::GetSceneRequest* request,
                         v1::Scene* response) override {
    return OnScene("SceneService/GetScene", context, request, response, [=](Scene& scene) {
      *response = ToProto(scene);
      return absl::OkStatus();
    });
  }

  UnaryReactor* ListScenes(Context* context, const v1::ListScenesRequest* request,
                           v1::ListScenesResponse* response) override {
    return RunUnary(env_, context, "SceneService/ListScenes", *request, response,
                    [=, this](const CallInfo&) { return List(*request, response); });
  }

  UnaryReactor* DeleteScene(Context* context, const v1::DeleteSceneRequest* request,
                            v1::DeleteSceneResponse* response) override {
    return OnScene("SceneService/DeleteScene", context, request, response,
                   [=, this](Scene& scene) { return env_->scenes->Delete(scene.id()); });
  }

  UnaryReactor* GetLattice(Context* context, const v1::GetLatticeRequest* request,
                           v1::LatticeState* response) override {
    return OnScene("SceneService/GetLattice", context, request, response, [=](Scene& scene) {
      *response = LatticeStateToProto(*scene.State());
      return absl::OkStatus();
    });
  }

  UnaryReactor* ApplyEdits(Context* context, const v1::EditBatch* request,
                           v1::EditResult* response) override {
    const auto arrived = Clock::now();
    return OnScene(
        "SceneService/ApplyEdits", context, request, response, [=](Scene& scene) -> absl::Status {
          const auto begun = Clock::now();
          LATTICED_ASSIGN_OR_RETURN(
              const auto summary, scene.ApplyEdits(BatchFromProto(*request, *scene.config().mesh),
                                                   [context] { return CheckCancelled(*context); }));
          *response = ToProto(summary);
          response->mutable_timings()->set_queue_us(
              Microseconds(absl::FromChrono(begun - arrived)));
          response->mutable_timings()->set_apply_us(
              Microseconds(absl::FromChrono(summary.commit_time.value_or(Clock::now()) - begun)));
          return absl::OkStatus();
        });
  }

  UnaryReactor* EvaluatePoints(Context* context, const v1::EvaluatePointsRequest* request,
                               v1::EvaluatePointsResponse* response) override {
    return OnScene("SceneService/EvaluatePoints", context, request, response, [=](Scene& scene) {
      return latticed::EvaluatePoints(*scene.State(), *request, response);
    });
  }

  UnaryReactor* Pick(Context* context, const v1::PickRequest* request,
                     v1::SurfacePoint* response) override {
    return OnScene("SceneService/Pick", context, request, response, [=](Scene& scene) {
      return latticed::Pick(
          *scene.State(), *request, [context] { return CheckCancelled(*context); }, response);
    });
  }

  UnaryReactor* ControlWatch(Context* context, const v1::ControlWatchRequest* request,
                             v1::ControlWatchResponse* response) override {
    return RunUnary(env_, context, "SceneService/ControlWatch", *request, response,
                    [=, this](const CallInfo& call) -> absl::Status {
                      if (auto s = CheckSceneMetadata(*context, request->scene());
                          !request->scene().empty() && !s.ok()) {
                        return s;
                      }
                      if (auto s = CheckRole(call.caller, "SceneService/ApplyEdits");
                          request->has_presence() && !s.ok()) {
                        return s;
                      }
                      return latticed::ControlWatch(env_, *request, response);
                    });
  }

  grpc::ServerWriteReactor<v1::TopologyPart>* GetTopology(
      Context* context, const v1::GetTopologyRequest* request) override {
    return new PartStream<v1::TopologyPart>(
        env_, context, "SceneService/GetTopology", *request, request->scene(),
        [=, this](const auto&) { return OpenTopology(*context, *request); });
  }

  grpc::ServerWriteReactor<v1::ExportResponse>* Export(Context* context,
                                                       const v1::ExportRequest* request) override {
    return new PartStream<v1::ExportResponse>(env_, context, "SceneService/Export", *request,
                                              request->scene(),
                                              [=, this](const Cancelled& cancelled) {
                                                return OpenExport(*context, *request, cancelled);
                                              });
  }

  grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* Deform(Context* context) override {
    return NewDeformStream(env_, context);
  }
  grpc::ServerWriteReactor<grpc::ByteBuffer>* Watch(Context* context,
                                                    const grpc::ByteBuffer* request) override {
    return NewWatchStream(env_, context, request);
  }
  grpc::ServerWriteReactor<grpc::ByteBuffer>* GetUpdate(Context* context,
                                                        const grpc::ByteBuffer* request) override {
    return NewGetUpdateStream(env_, context, request);
  }

 private:
  template <typename Request, typename Work>
  UnaryReactor* OnScene(std::string_view rpc, Context* context, const Request* request,
                        google::protobuf::Message* response, Work work) {
    return RunUnary(
        env_, context, rpc, *request, response,
        [this, context, request, work = std::move(work)](const CallInfo&) -> absl::Status {
          const auto scene = FindScene(*env_, *context, request->scene());
          return scene.ok() ? work(**scene) : scene.status();
        });
  }

  absl::Status Create(const CallInfo& call, const v1::CreateSceneRequest& request, ReplyRoom& room,
                      v1::Scene* response) {
    LATTICED_RETURN_IF_ERROR(CheckCreateScene(request));
    LATTICED_RETURN_IF_ERROR(CheckSceneMetadata(*call.context, request.scene_id()));
    LATTICED_ASSIGN_OR_RETURN(const auto mesh, env_->meshes.Find(request.mesh()));
    LATTICED_ASSIGN_OR_RETURN(auto config, SceneConfigFromProto(request, *mesh, call.caller.name,
                                                                env_->options.scene_idle_ttl));
    LATTICED_RETURN_IF_ERROR(room.Hold(SceneReplyBytes(request)));
    // The mesh may have been deleted since it was found.
    LATTICED_ASSIGN_OR_RETURN(
        const auto scene,
        env_->scenes->Create(
            std::move(config), [&] { return env_->meshes.Find(request.mesh()).status(); },
            [&] { return CheckCancelled(*call.context); }));
    *response = ToProto(*scene);
    return absl::OkStatus();
  }

  std::vector<std::shared_ptr<Scene>> AllScenes(
      const std::function<bool(const Scene&)>& accept) const {
    return env_->scenes->List("", std::numeric_limits<size_t>::max(), accept);
  }

  absl::Status List(const v1::ListScenesRequest& request, v1::ListScenesResponse* response) const {
    LATTICED_ASSIGN_OR_RETURN(const auto size, PageSize(request.page_size()));
    LATTICED_ASSIGN_OR_RETURN(const auto filter, LabelFilter::Parse(request.filter()));
    LATTICED_ASSIGN_OR_RETURN(const auto after, FromToken(request.page_token()));
    auto scenes = AllScenes([&](const Scene& scene) {
      return filter.Matches(scene.config().labels) && KeyOf(scene) > after;
    });
    std::ranges::sort(scenes, {}, [](const auto& scene) { return KeyOf(*scene); });
    PageRoom room(size);
    PageKey last;
    for (const auto& scene : scenes) {
      v1::Scene item = ToProto(*scene);
      if (!room.Take(item.ByteSizeLong())) {
        response->set_next_page_token(ToToken(last));
        break;
      }
      *response->add_scenes() = std::move(item);
      last = KeyOf(*scene);
    }
    return absl::OkStatus();
  }

  absl::StatusOr<PartStream<v1::TopologyPart>::Next> OpenTopology(
      const Context& context, const v1::GetTopologyRequest& request) const {
    LATTICED_ASSIGN_OR_RETURN(const auto scene, FindScene(*env_, context, request.scene()));
    const auto plan = scene->State()->plan;
    if (!IsTopologyOf(request.topology_id(), scene->config().mesh_id, plan->structure)) {
      return error::NotFound("topology", request.topology_id());
    }
    return [plan, id = request.topology_id(),
            first = size_t{0}]() mutable -> absl::StatusOr<std::optional<v1::TopologyPart>> {
      if (first >= plan->patches.size()) return std::nullopt;
      auto part = MakeTopologyPart(*plan, id, first);
      first += kPatchesPerTopologyPart;
      return part;
    };
  }

  absl::StatusOr<PartStream<v1::ExportResponse>::Next> OpenExport(
      const Context& context, const v1::ExportRequest& request, const Cancelled& cancelled) const {
    LATTICED_ASSIGN_OR_RETURN(const auto scene, FindScene(*env_, context, request.scene()));
    const RenderInput head = scene->Head();
    const SceneState* const state = head.state.get();
    if (request.revision() != 0 && request.revision() != state->revision) {
      return error::WithDetails(
          absl::AbortedError(fmt::format("revision: got {}, the scene is at {}", request.revision(),
                                         state->revision)),
          {.reason = "REVISION_CHANGED",
           .metadata = {{"revision", fmt::to_string(state->revision)}}});
    }
    LATTICED_ASSIGN_OR_RETURN(auto spec,
                              ExportSpecFromProto(request, scene->config().default_view));
    // A mesh that is gone takes its scene along: then the export is the last of it, without units.
    if (const auto mesh = env_->meshes.Find(scene->config().mesh_id); mesh.ok()) {
      spec.units = {(*mesh)->up_axis, (*mesh)->meters_per_unit};
    }
    const auto hold = scene->Hold();
    const uint64_t most = ExportMemoryBytes(*state->plan, spec);
    LATTICED_ASSIGN_OR_RETURN(auto room, env_->memory->Reserve("the export", most));
    LATTICED_ASSIGN_OR_RETURN(auto bytes, ExportSurface(head, spec, cancelled));

    v1::ExportHeader header;
    header.set_revision(state->revision);
    header.set_media_type(std::string(ExportMediaType(spec.format)));
    header.set_file_name(fmt::format("{}.{}", scene->id(), ExportExtension(spec.format)));
    header.set_bytes(bytes.size());
    struct File {
      std::string bytes;
      MemoryReservation room;
    };
    const auto file = std::make_shared<const File>(File{std::move(bytes), std::move(room)});
    return FileParts<v1::ExportResponse>(std::move(header), {file, &file->bytes});
  }

  ServerEnv* const env_;
};

}  // namespace

std::unique_ptr<grpc::Service> MakeSceneService(ServerEnv* env) {
  return std::make_unique<SceneServiceImpl>(env);
}

}  // namespace latticed
