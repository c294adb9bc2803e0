// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <chrono>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/base/utf8.h"
#include "fmt/format.h"
#include "latticed/v1/scene.grpc.pb.h"
#include "server/base/auth/tenant.h"
#include "server/base/random_id.h"
#include "server/engine/exports/surface_export.h"
#include "server/engine/scene/topology_id.h"
#include "server/engine/watch/view_tolerance.h"
#include "server/engine/watch_control.h"
#include "server/rpc/access/audit.h"
#include "server/rpc/access/quota_access.h"
#include "server/rpc/access/tenant_access.h"
#include "server/rpc/certify_folds.h"
#include "server/rpc/deform_stream.h"
#include "server/rpc/measure_scene.h"
#include "server/rpc/method.h"
#include "server/rpc/patch_plan.h"
#include "server/rpc/scene_list.h"
#include "server/rpc/server_env.h"
#include "server/rpc/services.h"
#include "server/rpc/topology.h"
#include "server/rpc/update_stream.h"
#include "server/rpc/watch_request.h"
#include "server/store/store_errors.h"
#include "server/stores/callers.h"
#include "server/stores/scene_registry.h"
#include "server/wire/converters.h"
#include "server/wire/edit_converters.h"
#include "server/wire/scene_converters.h"
#include "server/wire/stored_scene.h"
#include "server/wire/time_converters.h"

namespace latticed {
namespace {

using Clock = std::chrono::steady_clock;
using Context = grpc::CallbackServerContext;
using Bytes = grpc::ByteBuffer;
using UnaryReactor = grpc::ServerUnaryReactor;
using Writer = grpc::ServerWriteReactor<Bytes>;

absl::StatusOr<std::shared_ptr<Scene>> SceneOf(const CallContext& context,
                                               const std::string& scene) {
  return FindScene(context.env, context.call, scene);
}

// The most bytes of the reply for a new scene. Only its labels may be large.
uint64_t SceneReplyBytes(const v1::CreateSceneRequest& request) {
  constexpr uint64_t kAllButLabels = 6 << 10;
  v1::Scene scene;
  *scene.mutable_labels() = request.labels();
  return kAllButLabels + ReplyBytes(scene);
}

absl::Status CreateScene(const CallContext& context, const v1::CreateSceneRequest& request,
                         v1::Scene& response) {
  ServerEnv& env = context.env;
  LATTICED_RETURN_IF_ERROR(CheckCreateScene(request));
  LATTICED_RETURN_IF_ERROR(CheckSceneMetadata(context.call, request.scene_id()));
  LATTICED_ASSIGN_OR_RETURN(const auto mesh, FindMesh(env, context.call, request.mesh()));
  LATTICED_ASSIGN_OR_RETURN(
      auto config,
      SceneConfigFromProto(request, *mesh, context.call.caller.name, env.options.scene_idle_ttl));
  const absl::Time create_time = config.create_time;
  const CallerAccount& caller = *context.call.account;
  config.account = caller.memory;
  config.token_key = NewRandomId();
  config.stored_header = StoredHeaderOf(request, config);
  LATTICED_RETURN_IF_ERROR(context.room.Hold(SceneReplyBytes(request)));
  // Create looks for the mesh again, because it may have been deleted meanwhile.
  const auto has_mesh = [&] {
    return env.meshes.InMemory(mesh->id) != nullptr ? absl::OkStatus()
                                                    : error::NotFound("mesh", request.mesh());
  };
  LATTICED_ASSIGN_OR_RETURN(auto check_quota, SceneQuotaCheck(env, context.call.caller.tenant));
  const auto scene =
      env.scenes->Create(std::move(config), has_mesh, [&] { return CheckCancelled(context.call); },
                         {.of_account = caller.ShareOf(static_cast<size_t>(env.options.max_scenes)),
                          .of_tenant = std::move(check_quota)});
  const absl::Status made = OrOnFreerServer(env, scene.status());
  NoteOwner(env, context.call, made);
  LATTICED_RETURN_IF_ERROR(made);
  if ((*scene)->create_time() == create_time) {  // else an equal request has made it before
    Audit(env, context.call, "scene_created",
          {{"scene", request.scene_id()}, {"mesh", request.mesh()}});
  }
  response = ToProto(**scene);
  return absl::OkStatus();
}

absl::Status GetScene(const CallContext& context, const v1::GetSceneRequest& request,
                      v1::Scene& response) {
  LATTICED_ASSIGN_OR_RETURN(const auto scene, SceneOf(context, request.scene()));
  response = ToProto(*scene);
  return absl::OkStatus();
}

absl::Status DeleteScene(const CallContext& context, const v1::DeleteSceneRequest& request,
                         v1::DeleteSceneResponse&) {
  // A scene that cannot be woken can still be deleted.
  if (request.scene().empty()) return error::InvalidField("scene", "is required");
  LATTICED_RETURN_IF_ERROR(CheckSceneMetadata(context.call, request.scene()));
  absl::Status deleted = context.env.scenes->Delete(KeyFor(context.call, request.scene()));
  if (error::IsSceneMoved(deleted)) NoteOwner(context.env, context.call, deleted);
  if (deleted.ok()) {
    Audit(context.env, context.call, "scene_deleted", {{"scene", request.scene()}});
  }
  return ToldById(deleted, "scene", request.scene());
}

absl::Status GetLattice(const CallContext& context, const v1::GetLatticeRequest& request,
                        v1::LatticeState& response) {
  LATTICED_ASSIGN_OR_RETURN(const auto scene, SceneOf(context, request.scene()));
  const auto state = scene->State();
  LATTICED_RETURN_IF_ERROR(CheckLattice(state->lattices, request.lattice(), "lattice"));
  response = LatticeStateToProto(*state, PlaceOf(state->lattices, request.lattice()));
  return absl::OkStatus();
}

absl::Status ApplyEdits(const CallContext& context, const v1::EditBatch& request,
                        v1::EditResult& response) {
  LATTICED_ASSIGN_OR_RETURN(const auto scene, SceneOf(context, request.scene()));
  LATTICED_RETURN_IF_ERROR(context.env.quotas.TakeEdit(context.call.caller.tenant, absl::Now()));
  const auto begun = Clock::now();
  LATTICED_ASSIGN_OR_RETURN(const auto summary,
                            scene->ApplyEdits(BatchFromProto(request, *scene->State()->plan),
                                              [&] { return CheckCancelled(context.call); }));
  AuditEdit(context.env, context.call, scene->id());
  response = ToProto(summary);
  const auto ended = summary.commit_time.value_or(Clock::now());
  v1::EditTimings& timings = *response.mutable_timings();
  timings.set_queue_us(Microseconds(absl::FromChrono(begun - context.call.arrival)));
  timings.set_apply_us(Microseconds(absl::FromChrono(ended - begun)));
  return absl::OkStatus();
}

absl::Status EvaluateScene(const CallContext& context, const v1::EvaluatePointsRequest& request,
                           v1::EvaluatePointsResponse& response) {
  LATTICED_ASSIGN_OR_RETURN(const auto scene, SceneOf(context, request.scene()));
  return EvaluatePoints(*scene->State(), request, &response);
}

absl::Status PickInScene(const CallContext& context, const v1::PickRequest& request,
                         v1::SurfacePoint& response) {
  LATTICED_ASSIGN_OR_RETURN(const auto scene, SceneOf(context, request.scene()));
  return Pick(
      *scene->State(), request, [&] { return CheckCancelled(context.call); }, &response);
}

absl::Status MeasureScene(const CallContext& context, const v1::MeasureSceneRequest& request,
                          v1::MeasureSceneResponse& response) {
  LATTICED_ASSIGN_OR_RETURN(const auto scene, SceneOf(context, request.scene()));
  const auto state = scene->State();
  const auto hold = scene->Hold();
  LATTICED_RETURN_IF_ERROR(context.room.Hold(MeasureReplyBytes(*state, request)));
  return MeasureState(
      *state, request, [&] { return CheckCancelled(context.call); }, &response);
}

absl::Status ControlWatch(const CallContext& context, const v1::ControlWatchRequest& request,
                          v1::ControlWatchResponse& response) {
  if (!request.scene().empty()) {
    LATTICED_RETURN_IF_ERROR(CheckSceneMetadata(context.call, request.scene()));
  }
  if (request.has_presence()) {
    LATTICED_RETURN_IF_ERROR(CheckRole(context.call.caller, kApplyEditsRpc));
  }
  if (request.watch_id().empty()) return error::InvalidField("watch_id", "is required");
  LATTICED_ASSIGN_OR_RETURN(
      auto watch, context.env.scenes->FindWatch(KeyFor(context.call, request.watch_id())));
  const Scene& scene = watch->scene();
  const auto& shared = context.call.caller.shared;
  if (shared.has_value() && shared->scene != scene.id()) {
    return error::NotFound("watch", request.watch_id());
  }
  LATTICED_ASSIGN_OR_RETURN(const auto command, FromProto(request, scene));
  LATTICED_RETURN_IF_ERROR(watch->Control(command));
  response.set_head_revision(scene.State()->revision);
  return absl::OkStatus();
}

absl::StatusOr<NextPart<v1::TopologyPart>> OpenTopology(const CallContext& context,
                                                        const v1::GetTopologyRequest& request) {
  LATTICED_ASSIGN_OR_RETURN(const auto scene, SceneOf(context, request.scene()));
  const auto plan = scene->State()->plan;
  const std::string mesh = WeightedMeshId(IdOf(scene->config().mesh_id), plan->mesh_weights);
  if (!IsTopologyOf(request.topology_id(), mesh, *plan)) {
    return error::NotFound("topology", request.topology_id());
  }
  return [plan, id = request.topology_id(),
          first = size_t{0}]() mutable -> absl::StatusOr<std::optional<v1::TopologyPart>> {
    if (first >= plan->patches.size()) return std::nullopt;
    return MakeTopologyPart(*plan, id, std::exchange(first, first + kPatchesPerTopologyPart));
  };
}

// cow-deformed.glb, by the scene's name or else its id, in letters that file systems take; not hidden.
std::string ExportFileName(const Scene& scene, const ExportSpec& spec) {
  constexpr size_t kMostBytes = 200;  // of 255, which most file systems take
  const std::string full =
      scene.config().name.empty() ? std::string(IdOf(scene.id())) : scene.config().name;
  std::string name(CutUtf8(full, kMostBytes));
  for (char& c : name) {
    if (absl::ascii_iscntrl(static_cast<unsigned char>(c)) || absl::StrContains("/\\:*?\"<>|", c))
      c = '_';
  }
  if (name.front() == '.') name.front() = '_';
  return fmt::format("{}-deformed.{}", name, ExportExtension(spec.format));
}

// The uploaded file, for its materials; nothing if its mesh was deleted, or has no such file.
void SetUpload(const Scene& scene, MeshStore& meshes, ExportSpec* spec) {
  const auto stored = meshes.Find(scene.config().mesh_id);
  if (!stored.ok()) return;
  const UploadFormat format = (*stored)->format;
  const bool is_kept = (format == UploadFormat::kObj && spec->format == MeshFormat::kObj) ||
                       (format == UploadFormat::kGlb && spec->format == MeshFormat::kGlb);
  if (!is_kept) return;
  // With the whole mesh, whose reservation counts its bytes.
  spec->upload = std::shared_ptr<const std::string>(*stored, (*stored)->bytes.get());
}

// Checks the tolerance of an export, and chooses the position bits of DRC where they are 0.
absl::Status SettleTolerance(const RenderInput& head, ExportSpec* spec) {
  const bool drc = spec->format == MeshFormat::kDraco;
  WatchView view;
  view.key.spec = {.tolerance = spec->tolerance,
                   .format = drc ? VertexFormat::kQuantised : VertexFormat::kFloat32,
                   .position_bits = spec->position_bits};
  LATTICED_ASSIGN_OR_RETURN(view, SettleTolerance(view, *head.target, head.state->box, "view"));
  spec->position_bits = view.key.spec.position_bits;
  return absl::OkStatus();
}

absl::StatusOr<NextPart<v1::ExportResponse>> OpenExport(const CallContext& context,
                                                        const v1::ExportRequest& request) {
  ServerEnv& env = context.env;
  LATTICED_ASSIGN_OR_RETURN(const auto scene, SceneOf(context, request.scene()));
  const RenderInput head = scene->Head();
  const SceneState* const state = head.state.get();
  if (request.revision() != 0 && request.revision() != state->revision) {
    return error::WithDetails(absl::AbortedError(fmt::format("revision: got {}, the scene is at {}",
                                                             request.revision(), state->revision)),
                              {.reason = "REVISION_CHANGED",
                               .metadata = {{"revision", fmt::to_string(state->revision)}}});
  }
  LATTICED_ASSIGN_OR_RETURN(auto spec, ExportSpecFromProto(request, scene->config().default_view));
  LATTICED_RETURN_IF_ERROR(SettleTolerance(head, &spec));
  spec.units = scene->config().units;
  SetUpload(*scene, env.meshes, &spec);
  const auto hold = scene->Hold();
  const uint64_t most = ExportMemoryBytes(*state->plan, spec);
  LATTICED_ASSIGN_OR_RETURN(auto room,
                            env.memory->Reserve("the export", most, context.call.account->memory));
  const auto stop = [&] { return CheckCancelled(context.call); };
  LATTICED_ASSIGN_OR_RETURN(auto exported, ExportSurface(head, spec, stop));

  v1::ExportHeader header;
  header.set_revision(state->revision);
  header.set_media_type(std::string(ExportMediaType(spec.format)));
  header.set_file_name(ExportFileName(*scene, spec));
  header.set_bytes(exported.bytes.size());
  header.set_certified_error(exported.certified_error);
  struct File {
    std::string bytes;
    MemoryReservation room;
  };
  const auto file = std::make_shared<const File>(File{std::move(exported.bytes), std::move(room)});
  return FileParts<v1::ExportResponse>(std::move(header), {file, &file->bytes});
}

// Every rpc of the service: name, role, handler; kForShares where a share's token is enough. Deform needs only the role
// "read", because readers may watch through it. Each edit in it is checked as ApplyEdits is.
constexpr UnaryMethod kCreateScene{Rpc{"SceneService/CreateScene", Role::kEdit}, CreateScene,
                                   Lane::kLong};
constexpr UnaryMethod kGetScene{Rpc{"SceneService/GetScene", Role::kRead, kForShares}, GetScene};
constexpr UnaryMethod kListScenes{Rpc{"SceneService/ListScenes", Role::kRead}, ListScenes,
                                  Lane::kLong};
constexpr UnaryMethod kDeleteScene{Rpc{"SceneService/DeleteScene", Role::kEdit}, DeleteScene,
                                   Lane::kLong};
constexpr UnaryMethod kGetLattice{Rpc{"SceneService/GetLattice", Role::kRead, kForShares},
                                  GetLattice};
constexpr UnaryMethod kApplyEdits{kApplyEditsRpc, ApplyEdits};
constexpr UnaryMethod kEvaluatePoints{Rpc{"SceneService/EvaluatePoints", Role::kRead, kForShares},
                                      EvaluateScene};
constexpr UnaryMethod kPick{Rpc{"SceneService/Pick", Role::kRead, kForShares}, PickInScene};
constexpr UnaryMethod kCertifyFolds{Rpc{"SceneService/CertifyFolds", Role::kRead, kForShares},
                                    CertifyFolds, Lane::kLong};
constexpr UnaryMethod kMeasureScene{Rpc{"SceneService/MeasureScene", Role::kRead, kForShares},
                                    MeasureScene, Lane::kLong};
constexpr UnaryMethod kControlWatch{Rpc{"SceneService/ControlWatch", Role::kRead, kForShares},
                                    ControlWatch};
constexpr PartMethod kGetTopology{Rpc{"SceneService/GetTopology", Role::kRead, kForShares},
                                  OpenTopology, Parts::kComputed};
constexpr PartMethod kGetPatchPlan{Rpc{"SceneService/GetPatchPlan", Role::kRead, kForShares},
                                   OpenPatchPlan, Parts::kComputed, Lane::kLong};
constexpr PartMethod kExport{Rpc{"SceneService/Export", Role::kRead, kForShares}, OpenExport,
                             Parts::kCopied, Lane::kLong};
constexpr Rpc kDeform{"SceneService/Deform", Role::kRead, kForShares};
constexpr Rpc kWatch{"SceneService/Watch", Role::kRead, kForShares};
constexpr Rpc kGetUpdate{"SceneService/GetUpdate", Role::kRead, kForShares};

// Every rpc takes and gives bytes (server/wire/message_bytes.h), so chunks are also sent without a copy.
using S = v1::SceneService;
using Streams = S::WithRawCallbackMethod_Deform<
    S::WithRawCallbackMethod_Watch<S::WithRawCallbackMethod_GetUpdate<S::Service>>>;
using Scenes = S::WithRawCallbackMethod_CreateScene<S::WithRawCallbackMethod_GetScene<
    S::WithRawCallbackMethod_ListScenes<S::WithRawCallbackMethod_DeleteScene<Streams>>>>;
using Edits = S::WithRawCallbackMethod_GetLattice<
    S::WithRawCallbackMethod_ApplyEdits<S::WithRawCallbackMethod_ControlWatch<Scenes>>>;
using Plans = S::WithRawCallbackMethod_GetTopology<S::WithRawCallbackMethod_GetPatchPlan<Edits>>;
using Points = S::WithRawCallbackMethod_Pick<S::WithRawCallbackMethod_EvaluatePoints<Plans>>;
using Measures =
    S::WithRawCallbackMethod_CertifyFolds<S::WithRawCallbackMethod_MeasureScene<Points>>;
using SceneServiceBase = S::WithRawCallbackMethod_Export<Measures>;

class SceneServiceImpl final : public SceneServiceBase {
 public:
  explicit SceneServiceImpl(ServerEnv* env) : env_(env) {}

  UnaryReactor* CreateScene(Context* context, const Bytes* request, Bytes* response) override {
    return kCreateScene.Run(env_, context, request, response);
  }
  UnaryReactor* GetScene(Context* context, const Bytes* request, Bytes* response) override {
    return kGetScene.Run(env_, context, request, response);
  }
  UnaryReactor* ListScenes(Context* context, const Bytes* request, Bytes* response) override {
    return kListScenes.Run(env_, context, request, response);
  }
  UnaryReactor* DeleteScene(Context* context, const Bytes* request, Bytes* response) override {
    return kDeleteScene.Run(env_, context, request, response);
  }
  UnaryReactor* GetLattice(Context* context, const Bytes* request, Bytes* response) override {
    return kGetLattice.Run(env_, context, request, response);
  }
  UnaryReactor* ApplyEdits(Context* context, const Bytes* request, Bytes* response) override {
    return kApplyEdits.Run(env_, context, request, response);
  }
  UnaryReactor* EvaluatePoints(Context* context, const Bytes* request, Bytes* response) override {
    return kEvaluatePoints.Run(env_, context, request, response);
  }
  UnaryReactor* Pick(Context* context, const Bytes* request, Bytes* response) override {
    return kPick.Run(env_, context, request, response);
  }
  UnaryReactor* CertifyFolds(Context* context, const Bytes* request, Bytes* response) override {
    return kCertifyFolds.Run(env_, context, request, response);
  }
  UnaryReactor* MeasureScene(Context* context, const Bytes* request, Bytes* response) override {
    return kMeasureScene.Run(env_, context, request, response);
  }
  UnaryReactor* ControlWatch(Context* context, const Bytes* request, Bytes* response) override {
    return kControlWatch.Run(env_, context, request, response);
  }
  Writer* GetTopology(Context* context, const Bytes* request) override {
    return kGetTopology.Run(env_, context, request);
  }
  Writer* GetPatchPlan(Context* context, const Bytes* request) override {
    return kGetPatchPlan.Run(env_, context, request);
  }
  Writer* Export(Context* context, const Bytes* request) override {
    return kExport.Run(env_, context, request);
  }
  grpc::ServerBidiReactor<Bytes, Bytes>* Deform(Context* context) override {
    return NewDeformStream(kDeform, env_, context);
  }
  Writer* Watch(Context* context, const Bytes* request) override {
    return UpdateStream<v1::WatchRequest>::New(env_, context, kWatch, *request);
  }
  Writer* GetUpdate(Context* context, const Bytes* request) override {
    return UpdateStream<v1::GetUpdateRequest>::New(env_, context, kGetUpdate, *request);
  }

 private:
  ServerEnv* const env_;
};

}  // namespace

std::unique_ptr<grpc::Service> MakeSceneService(ServerEnv* env) {
  return std::make_unique<SceneServiceImpl>(env);
}

}  // namespace latticed
