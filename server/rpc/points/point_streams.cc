// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/points/point_streams.h"

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "latticed/v1/points.pb.h"
#include "server/base/random_id.h"
#include "server/rpc/access/audit.h"
#include "server/rpc/access/quota_access.h"
#include "server/rpc/points/data_stream.h"
#include "server/rpc/points/point_source.h"
#include "server/rpc/points/points_at_head.h"
#include "server/rpc/watch_request.h"

namespace latticed {
namespace {

class PointSetReceiver {
 public:
  using Request = v1::CreatePointSetRequest;
  using Response = v1::PointSet;

  PointSetReceiver(ServerEnv& env, const CallInfo& call) : env_(env), call_(call) {}

  absl::StatusOr<uint64_t> Open(const v1::PointSetHeader& header) {
    header_ = header;
    LATTICED_ASSIGN_OR_RETURN(scene_, FindScene(env_, call_, header.scene()));
    scene_->NoteUse();
    state_ = scene_->State();
    LATTICED_ASSIGN_OR_RETURN(announced_, Announced(header, *scene_, *state_));
    LATTICED_RETURN_IF_ERROR(scene_->point_sets().CheckRoom());
    LATTICED_RETURN_IF_ERROR(
        CheckPointSetQuota(env_, call_.caller.tenant,
                           PointSet::BytesFor(*state_->plan, announced_.points,
                                              announced_.with_normals, announced_.with_weights)));
    return announced_.data_bytes;
  }

  absl::Status Finish(std::vector<double> data, v1::PointSet& response) {
    const MemoryAccountPtr& account = call_.account->memory;
    MemoryReservation rest;  // for points that are made here
    if (!header_.has_world()) {
      LATTICED_ASSIGN_OR_RETURN(
          rest, env_.memory->Reserve("the points", announced_.MadeBytes(), account));
    }
    LATTICED_ASSIGN_OR_RETURN(RestNumbers numbers,
                              RestPoints(header_, *scene_, *state_, std::move(data)));
    const std::span<const Vec3d> vectors = AsVectors(numbers.vectors);
    const size_t points = announced_.points;
    LATTICED_ASSIGN_OR_RETURN(
        auto set, PointSet::Make(NewRandomId(), *state_,
                                 {vectors.first(points), vectors.subspan(points), numbers.weights},
                                 scene_->backend(), account, *env_.point_arena));
    LATTICED_RETURN_IF_ERROR(CheckCancelled(call_));
    // Others may have made sets meanwhile.
    LATTICED_RETURN_IF_ERROR(
        CheckPointSetQuota(env_, call_.caller.tenant, set->Newest()->memory.bytes()));
    LATTICED_RETURN_IF_ERROR(scene_->point_sets().Add(set));
    // The scene may have been deleted meanwhile, and its sets with it.
    if (const absl::Status ended = scene_->ended(); !ended.ok()) {
      return ToldById(ended, "scene", header_.scene());
    }
    response = ToProto(*scene_, *set);
    Audit(env_, call_, "point_set_created", {{"scene", header_.scene()}, {"point_set", set->id()}});
    return absl::OkStatus();
  }

 private:
  ServerEnv& env_;
  const CallInfo& call_;
  v1::PointSetHeader header_;
  std::shared_ptr<Scene> scene_;
  std::shared_ptr<const SceneState> state_;
  AnnouncedPoints announced_;
};

class CotangentReceiver {
 public:
  using Request = v1::ApplyJacobianTransposeRequest;
  using Response = v1::PointGradients;

  CotangentReceiver(ServerEnv& env, const CallInfo& call) : env_(env), call_(call) {}

  absl::StatusOr<uint64_t> Open(const v1::CotangentHeader& header) {
    header_ = header;
    LATTICED_ASSIGN_OR_RETURN(found_, FindPoints(env_, call_, header, "header."));
    directions_ = std::max<uint32_t>(header.directions(), 1);
    const size_t fit = limits::kMaxPartBytes / (found_.lattice_points() * sizeof(Vec3d));
    const size_t most = std::min<size_t>(fit, limits::kMaxDirections);
    LATTICED_RETURN_IF_ERROR(
        error::CheckRange("header.directions", directions_, 0, static_cast<double>(most)));
    return directions_ * found_.BytesPerDirection();
  }

  absl::Status Finish(std::vector<double> data, v1::PointGradients& response) {
    const std::span<const Vec3d> cotangents = AsVectors(data);
    LATTICED_RETURN_IF_ERROR(CheckFinite(cotangents, "data.cotangents"));
    const uint64_t sums =
        found_.resident->evaluator->TransposeBytes(directions_, found_.normals) + ContinuedBytes();
    LATTICED_ASSIGN_OR_RETURN(const auto room,
                              env_.memory->Reserve("the sums", sums, call_.account->memory));
    std::vector<Vec3d> gradients(directions_ * found_.control_points().size());
    LATTICED_RETURN_IF_ERROR(found_.Evaluate([&](PointEvaluator& points) {
      return points.ApplyJacobianTranspose(
          found_.control_points(), cotangents, found_.normals,
          [this] { return CheckCancelled(call_); }, gradients);
    }));
    if (ContinuedBytes() > 0) gradients = ByLattice(gradients);
    response.set_revision(found_.state->revision);
    response.set_structure_id(found_.state->structure_id);
    response.set_directions(directions_);
    response.set_gradients(reinterpret_cast<const char*>(gradients.data()),
                           gradients.size() * sizeof(Vec3d));
    return absl::OkStatus();
  }

 private:
  // What derivatives by the plan's control points take, where those are not the lattice's.
  uint64_t ContinuedBytes() const {
    if (found_.lattice().map->is_identity()) return 0;
    return directions_ * found_.control_points().size() * sizeof(Vec3d);
  }
  std::vector<Vec3d> ByLattice(const std::vector<Vec3d>& gradients) const {
    std::vector<Vec3d> result;
    for (size_t d = 0; d < directions_; ++d) {
      const size_t count = found_.control_points().size();
      const auto one = found_.lattice().map->ApplyTransposed(
          std::span<const Vec3d>(gradients).subspan(d * count, count));
      result.insert(result.end(), one.begin(), one.end());
    }
    return result;
  }

  ServerEnv& env_;
  const CallInfo& call_;
  v1::CotangentHeader header_;
  PointsAtHead found_;
  uint32_t directions_ = 1;
};

}  // namespace

grpc::ServerReadReactor<grpc::ByteBuffer>* NewCreatePointSet(const Rpc& rpc, ServerEnv* env,
                                                             grpc::CallbackServerContext* context,
                                                             grpc::ByteBuffer* reply) {
  return new DataStream<PointSetReceiver>(rpc, env, context, reply);
}

grpc::ServerReadReactor<grpc::ByteBuffer>* NewApplyJacobianTranspose(
    const Rpc& rpc, ServerEnv* env, grpc::CallbackServerContext* context, grpc::ByteBuffer* reply) {
  return new DataStream<CotangentReceiver>(rpc, env, context, reply);
}

}  // namespace latticed
