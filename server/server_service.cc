// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/server_service.h"

#include <unistd.h>

#include "core/base/limits.h"
#include "server/call.h"
#include "server/scene_registry.h"
#include "server/time_converters.h"
#include "server/version.h"

namespace latticed {
namespace {

uint64_t Pages(int name) {
  const long pages = sysconf(name);
  const long page_bytes = sysconf(_SC_PAGESIZE);
  return pages < 0 || page_bytes < 0
             ? 0
             : static_cast<uint64_t>(pages) * static_cast<uint64_t>(page_bytes);
}

void FillBackends(ServerEnv& env, v1::ServerInfo& info) {
  for (const auto& backend : env.backends) {
    v1::BackendInfo& out = *info.add_backends();
    out.set_name(std::string(backend->name()));
    out.set_description(backend->description());
    v1::DeviceInfo& device = *out.add_devices();
    device.set_name(backend->description());
    if (backend->name() != "cpu") continue;
    device.set_memory_bytes(Pages(_SC_PHYS_PAGES));
    device.set_free_bytes(Pages(_SC_AVPHYS_PAGES));
  }
  const absl::Status health = env.scenes->residency().health().status();
  if (!health.ok()) info.mutable_backends(0)->set_lost(std::string(health.message()));
}

void FillAbilities(v1::ServerInfo& info) {
  for (const auto encoding : {v1::ENCODING_DRACO_POINTS, v1::ENCODING_DRACO_MESH, v1::ENCODING_RAW,
                              v1::ENCODING_QUANTISED}) {
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

grpc::ServerUnaryReactor* ServerService::GetServerInfo(grpc::CallbackServerContext* context,
                                                       const v1::GetServerInfoRequest* /*request*/,
                                                       v1::ServerInfo* response) {
  return RunUnary(env_, context, "ServerService/GetServerInfo", [=, this](const CallInfo&) {
    response->set_version(std::string(Version()));
    response->set_commit(std::string(Commit()));
    response->set_boot_id(env_->boot_id);
    response->set_node(env_->node);
    FillBackends(*env_, *response);
    FillAbilities(*response);
    FillLimits(env_->options, *response->mutable_limits());
    SetDuration(env_->options.heartbeat_interval, *response->mutable_heartbeat());
    response->set_durable(false);
    return absl::OkStatus();
  });
}

}  // namespace latticed
