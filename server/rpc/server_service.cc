// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include <random>
#include <string>

#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "latticed/v1/server.grpc.pb.h"
#include "server/base/auth/tenant.h"
#include "server/base/version.h"
#include "server/rpc/access/quota_access.h"
#include "server/rpc/method.h"
#include "server/rpc/server_env.h"
#include "server/rpc/services.h"
#include "server/stores/scene_registry.h"
#include "server/wire/time_converters.h"

namespace latticed {
namespace {

void FillDevice(const DeviceState& state, v1::DeviceInfo& out) {
  out.set_number(static_cast<uint32_t>(state.number));
  out.set_name(state.name);
  out.set_memory_bytes(state.memory_bytes);
  out.set_free_bytes(state.free_bytes);
  out.set_budget_bytes(state.budget_bytes);
  out.mutable_bytes()->insert(state.use.begin(), state.use.end());
}

void FillBackends(ServerEnv& env, v1::ServerInfo& info) {
  for (const auto& backend : env.backends) {
    v1::BackendInfo& out = *info.add_backends();
    out.set_name(std::string(backend->name()));
    out.set_description(backend->description());
    for (const DeviceState& state : backend->devices()) FillDevice(state, *out.add_devices());
  }
  const absl::Status health = env.scenes->health().status();
  info.mutable_backends(0)->set_give_backs(env.scenes->evictions());
  if (!health.ok()) info.mutable_backends(0)->set_lost(std::string(health.message()));
}

void FillHostMemory(ServerEnv& env, v1::ServerInfo& info) {
  auto& bytes = *info.mutable_host_bytes();
  for (const auto& [purpose, size] : env.scenes->memory()) {
    if (!purpose.starts_with(kDevicePurpose)) bytes[purpose] = size;
  }
  for (const auto& mesh : env.meshes.All()) {
    bytes["mesh"] += mesh->MemoryBytes();
  }
  if (const uint64_t kept = env.memory->kept_bytes(); kept > 0) bytes["encoder"] = kept;
  info.set_reserved_host_bytes(env.memory->used_bytes());
}

void FillAbilities(v1::ServerInfo& info) {
  for (const auto encoding : {v1::ENCODING_DRACO_POINTS, v1::ENCODING_DRACO_MESH, v1::ENCODING_RAW,
                              v1::ENCODING_QUANTISED, v1::ENCODING_PATCHES, v1::ENCODING_MESHOPT}) {
    info.add_encodings(encoding);
  }
  for (const auto format : {v1::MESH_FORMAT_OBJ, v1::MESH_FORMAT_PLY, v1::MESH_FORMAT_STL,
                            v1::MESH_FORMAT_GLB, v1::MESH_FORMAT_DRACO, v1::MESH_FORMAT_RAW}) {
    info.add_mesh_formats(format);
  }
  for (const auto format :
       {v1::EXPORT_FORMAT_PLY, v1::EXPORT_FORMAT_OBJ, v1::EXPORT_FORMAT_STL, v1::EXPORT_FORMAT_GLB,
        v1::EXPORT_FORMAT_DRC, v1::EXPORT_FORMAT_CONTROL_NETS}) {
    info.add_export_formats(format);
  }
  for (const auto pipeline :
       {v1::PIPELINE_FUSED, v1::PIPELINE_GEMM, v1::PIPELINE_GEMM12, v1::PIPELINE_CONTROL_NET}) {
    info.add_pipelines(pipeline);
  }
  for (const auto feature : {v1::FEATURE_DRAG_POINTS, v1::FEATURE_PICK, v1::FEATURE_PRESENCE}) {
    info.add_features(feature);
  }
}

void FillLimits(const Options& options, v1::ServerLimits& out) {
  out.set_max_part_bytes(limits::kMaxPartBytes);
  out.set_max_message_bytes(limits::kMaxMessageBytes);
  out.set_max_mesh_bytes(options.max_mesh_bytes);
  out.set_max_mesh_vertices(limits::kMaxMeshVertices);
  out.set_max_mesh_faces(limits::kMaxMeshFaces);
  out.set_max_patches(limits::kMaxPatches);
  out.set_min_degree(limits::kMinDegree);
  out.set_max_degree(limits::kMaxDegree);
  out.set_max_control_points(limits::kMaxControlPoints);
  out.set_min_segments(limits::kMinSegments);
  out.set_max_segments(limits::kMaxSegments);
  out.set_min_position_bits(limits::kMinPositionBits);
  out.set_max_position_bits(limits::kMaxPositionBits);
  out.set_min_normal_bits(limits::kMinNormalBits);
  out.set_max_normal_bits(limits::kMaxNormalBits);
  out.set_max_views_per_scene(limits::kMaxViewsPerScene);
  out.set_max_watchers_per_scene(options.max_watchers);
  out.set_max_scenes(options.max_scenes);
  out.set_max_evaluate_points(limits::kMaxEvaluatePoints);
  out.set_max_drag_points(limits::kMaxDragPoints);
  out.set_max_point_set_points(limits::kMaxPointSetPoints);
  out.set_max_point_sets_per_scene(limits::kMaxPointSetsPerScene);
  out.set_max_directions(limits::kMaxDirections);
  out.set_max_presence_name(limits::kMaxPresenceName);
  out.set_max_presence_indices(limits::kMaxPresenceIndices);
  out.set_max_calls_per_connection(limits::kMaxCallsPerConnection);
  out.set_max_connections(static_cast<int32_t>(MostConnections(options)));
  out.set_max_uploads(limits::kMaxUploads);
  out.set_max_chunk_points(limits::kMaxChunkPoints);
  out.set_max_undo_steps(limits::kMaxUndoSteps);
  out.set_max_undo_bytes(limits::kMaxUndoBytes);
  out.set_max_editors_remembered(limits::kMaxEditorsRemembered);
  out.set_max_page_size(limits::kMaxPageSize);
  out.set_max_host_bytes(options.memory_bytes);
  SetDuration(absl::Seconds(limits::kGestureTimeoutSeconds), *out.mutable_gesture_timeout());
  SetDuration(absl::Seconds(limits::kUploadIdleSeconds), *out.mutable_upload_idle_timeout());
}

}  // namespace

v1::ServerInfo DescribeServer(ServerEnv& env) {
  v1::ServerInfo info;
  info.set_version(std::string(Version()));
  info.set_commit(std::string(Commit()));
  info.set_boot_id(env.boot_id);
  info.set_node(env.node);
  FillBackends(env, info);
  FillAbilities(info);
  if (!env.options.http.empty()) info.add_features(v1::FEATURE_HTTP);
  FillLimits(env.options, *info.mutable_limits());
  for (const DeviceState& device : env.backend().devices()) {
    v1::ServerLimits& limits = *info.mutable_limits();
    limits.set_max_device_bytes(limits.max_device_bytes() + device.budget_bytes);
  }
  FillHostMemory(env, info);
  const EngineCounts& counts = env.scenes->counts();
  info.set_retired_snapshots(counts.snapshots_retired.load());
  info.set_forgotten_undo_steps(counts.undo_steps_forgotten.load());
  info.set_superseded_updates(counts.updates_superseded.load());
  SetDuration(env.options.heartbeat_interval, *info.mutable_heartbeat());
  info.set_durable(env.store != nullptr);
  return info;
}

namespace {

// Bytes that no compression makes fewer.
const std::string& ProbeBytes() {
  static const auto* bytes = [] {
    auto* made = new std::string(limits::kMaxPartBytes, '\0');
    std::minstd_rand random(1);
    for (char& byte : *made) byte = static_cast<char>(random() >> 8);
    return made;
  }();
  return *bytes;
}

absl::Status GetServerInfo(const CallContext& context, const v1::GetServerInfoRequest& request,
                           v1::ServerInfo& response) {
  LATTICED_RETURN_IF_ERROR(
      error::CheckRange("probe_bytes", request.probe_bytes(), 0, double{limits::kMaxPartBytes}));
  response = DescribeServer(context.env);
  response.set_probe(ProbeBytes().data(), request.probe_bytes());
  const Caller& caller = context.call.caller;
  response.set_role(std::string(RoleName(caller.role)));
  if (caller.shared.has_value()) {
    response.set_shared_scene(std::string(IdOf(caller.shared->scene)));
    return absl::OkStatus();
  }
  const std::string& tenant = caller.tenant;
  response.set_tenant(tenant);
  LATTICED_ASSIGN_OR_RETURN(const auto uses, QuotasOf(context.env, tenant));
  for (const QuotaInUse& use : uses) {
    v1::QuotaUse& out = *response.add_quotas();
    out.set_what(QuotaName(use.kind));
    out.set_quota(use.quota);
    out.set_used(use.used);
  }
  return absl::OkStatus();
}

// Every rpc of the service: name, role, handler. What tenants have is asked of the store, which may take long.
constexpr Rpc kGetServerInfoRpc{"ServerService/GetServerInfo", Role::kRead, kForShares};
constexpr UnaryMethod kGetServerInfo{kGetServerInfoRpc, GetServerInfo};
constexpr UnaryMethod kGetServerInfoAndQuotas{kGetServerInfoRpc, GetServerInfo, Lane::kLong};

// The rpc takes and gives bytes (server/wire/message_bytes.h).
class ServerServiceImpl final
    : public v1::ServerService::WithRawCallbackMethod_GetServerInfo<v1::ServerService::Service> {
 public:
  explicit ServerServiceImpl(ServerEnv* env) : env_(env) {}

  grpc::ServerUnaryReactor* GetServerInfo(grpc::CallbackServerContext* context,
                                          const grpc::ByteBuffer* request,
                                          grpc::ByteBuffer* response) override {
    const auto& method =
        env_->options.quota_file.empty() ? kGetServerInfo : kGetServerInfoAndQuotas;
    return method.Run(env_, context, request, response);
  }

 private:
  ServerEnv* const env_;
};

}  // namespace

std::unique_ptr<grpc::Service> MakeServerService(ServerEnv* env) {
  return std::make_unique<ServerServiceImpl>(env);
}

}  // namespace latticed
