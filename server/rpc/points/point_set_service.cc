// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "core/points/point_derivatives.h"
#include "fmt/format.h"
#include "latticed/v1/points.grpc.pb.h"
#include "server/rpc/access/audit.h"
#include "server/rpc/method.h"
#include "server/rpc/points/point_source.h"
#include "server/rpc/points/point_streams.h"
#include "server/rpc/points/points_at_head.h"
#include "server/rpc/server_env.h"
#include "server/rpc/services.h"
#include "server/rpc/watch_request.h"

namespace latticed {
namespace {

absl::Status ListPointSets(const CallContext& context, const v1::ListPointSetsRequest& request,
                           v1::ListPointSetsResponse& response) {
  LATTICED_ASSIGN_OR_RETURN(const auto scene,
                            FindScene(context.env, context.call, request.scene()));
  for (const auto& set : scene->point_sets().All()) {
    *response.add_point_sets() = ToProto(*scene, *set);
  }
  return absl::OkStatus();
}

absl::Status DeletePointSet(const CallContext& context, const v1::DeletePointSetRequest& request,
                            v1::DeletePointSetResponse&) {
  LATTICED_ASSIGN_OR_RETURN(const auto scene,
                            FindScene(context.env, context.call, request.scene()));
  if (request.point_set().empty()) return error::InvalidField("point_set", "is required");
  LATTICED_RETURN_IF_ERROR(scene->point_sets().Remove(request.point_set()));
  Audit(context.env, context.call, "point_set_deleted",
        {{"scene", request.scene()}, {"point_set", request.point_set()}});
  return absl::OkStatus();
}

// Vectors of a call, and the memory that they take. Those of an answer are kept until the client has them.
struct Vectors {
  std::vector<Vec3d> vectors;
  MemoryReservation memory;
};

absl::StatusOr<std::shared_ptr<Vectors>> MakeAnswer(const CallContext& context,
                                                    const PointsAtHead& found, size_t directions) {
  LATTICED_ASSIGN_OR_RETURN(
      auto memory, context.env.memory->Reserve("the answer", directions * found.BytesPerDirection(),
                                               context.call.account->memory));
  return std::make_shared<Vectors>(
      Vectors{std::vector<Vec3d>(directions * VectorsPerDirection(found.points(), found.normals)),
              std::move(memory)});
}

// What the evaluator takes beside its arguments.
absl::StatusOr<MemoryReservation> ReserveSums(const CallContext& context, const PointsAtHead& found,
                                              size_t directions) {
  return context.env.memory->Reserve(
      "the sums", found.resident->evaluator->ForwardBytes(directions, found.normals),
      context.call.account->memory);
}

NextPart<v1::PointSetData> PartsOf(const PointsAtHead& found, size_t directions,
                                   std::shared_ptr<const Vectors> answer) {
  v1::PointSetData first;
  v1::PointSetDataHeader& header = *first.mutable_header();
  header.set_revision(found.state->revision);
  header.set_structure_id(found.state->structure_id);
  header.set_points(found.points().size());
  header.set_directions(static_cast<uint32_t>(directions));
  header.set_with_normals(found.normals == PointNormals::kWanted);
  return [header = std::optional(std::move(first)), answer = std::move(answer),
          offset = size_t{0}]() mutable -> absl::StatusOr<std::optional<v1::PointSetData>> {
    if (header.has_value()) return std::exchange(header, std::nullopt);
    const size_t bytes = answer->vectors.size() * sizeof(Vec3d);
    if (offset == bytes) return std::nullopt;
    const size_t size = std::min(limits::kMaxPartBytes, bytes - offset);
    v1::PointSetData part;
    part.set_data(reinterpret_cast<const char*>(answer->vectors.data()) + offset, size);
    offset += size;
    return part;
  };
}

absl::StatusOr<NextPart<v1::PointSetData>> OpenDeform(const CallContext& context,
                                                      const v1::DeformPointSetRequest& request) {
  LATTICED_ASSIGN_OR_RETURN(const auto found, FindPoints(context.env, context.call, request));
  LATTICED_ASSIGN_OR_RETURN(auto answer, MakeAnswer(context, found, 1));
  LATTICED_ASSIGN_OR_RETURN(const auto sums, ReserveSums(context, found, 1));
  LATTICED_RETURN_IF_ERROR(found.Evaluate([&](PointEvaluator& points) {
    return points.Deform(
        found.control_points(), found.normals, [&] { return CheckCancelled(context.call); },
        answer->vectors);
  }));
  return PartsOf(found, 1, std::move(answer));
}

// One vector per control point and direction; zero for those that do not move.
absl::StatusOr<Vectors> TangentsOf(const CallContext& context,
                                   const v1::ApplyJacobianRequest& request, size_t control_points) {
  const std::string& bytes = request.tangents();
  const size_t moving =
      request.indices().empty() ? control_points : static_cast<size_t>(request.indices_size());
  const size_t each = moving * sizeof(Vec3d);
  if (bytes.empty() || bytes.size() % each != 0) {
    return error::InvalidField("tangents",
                               fmt::format("got {} bytes; a direction has {} of {} control points",
                                           bytes.size(), each, moving));
  }
  const size_t directions = bytes.size() / each;
  LATTICED_RETURN_IF_ERROR(
      error::CheckRange("tangents", static_cast<double>(directions), 1, limits::kMaxDirections));
  if (bytes.size() > limits::kMaxPartBytes) {
    return error::OutOfRange("tangents", static_cast<double>(bytes.size()), 1,
                             static_cast<double>(limits::kMaxPartBytes));
  }
  std::vector<double> numbers(bytes.size() / sizeof(double));
  std::memcpy(numbers.data(), bytes.data(), bytes.size());
  const std::span<const Vec3d> given = AsVectors(numbers);
  LATTICED_RETURN_IF_ERROR(CheckFinite(given, "tangents"));
  // A few indices of many control points may become much more than the message.
  LATTICED_ASSIGN_OR_RETURN(
      auto memory,
      context.env.memory->Reserve("the tangents", directions * control_points * sizeof(Vec3d),
                                  context.call.account->memory));
  if (request.indices().empty()) {
    return Vectors{std::vector<Vec3d>(given.begin(), given.end()), std::move(memory)};
  }
  std::vector<Vec3d> tangents(directions * control_points);
  std::vector<bool> seen(control_points);
  for (size_t i = 0; i < moving; ++i) {
    const uint32_t index = request.indices(static_cast<int>(i));
    const std::string field = fmt::format("indices[{}]", i);
    LATTICED_RETURN_IF_ERROR(
        error::CheckRange(field, index, 0, static_cast<double>(control_points) - 1));
    if (seen[index]) return error::InvalidField(field, fmt::format("{} is named twice", index));
    seen[index] = true;
    for (size_t d = 0; d < directions; ++d) {
      tangents[d * control_points + index] = given[d * moving + i];
    }
  }
  return Vectors{std::move(tangents), std::move(memory)};
}

// Moves of the lattice's control points, as moves of the plan's.
absl::StatusOr<Vectors> Continued(const CallContext& context, const OutsideMap& outside,
                                  Vectors tangents) {
  if (outside.is_identity()) return tangents;
  const auto count = static_cast<size_t>(outside.structure().control_point_count());
  const auto continued = outside.planned_count();
  const size_t directions = tangents.vectors.size() / count;
  LATTICED_ASSIGN_OR_RETURN(auto memory, context.env.memory->Reserve(
                                             "the tangents", directions * continued * sizeof(Vec3d),
                                             context.call.account->memory));
  Vectors result{{}, std::move(memory)};
  result.vectors.reserve(directions * continued);
  for (size_t d = 0; d < directions; ++d) {
    const auto one =
        outside.Apply(std::span<const Vec3d>(tangents.vectors).subspan(d * count, count));
    result.vectors.insert(result.vectors.end(), one.begin(), one.end());
  }
  return result;
}

absl::StatusOr<NextPart<v1::PointSetData>> OpenJacobian(const CallContext& context,
                                                        const v1::ApplyJacobianRequest& request) {
  LATTICED_ASSIGN_OR_RETURN(const auto found, FindPoints(context.env, context.call, request));
  LATTICED_ASSIGN_OR_RETURN(auto given, TangentsOf(context, request, found.lattice_points()));
  const size_t directions = given.vectors.size() / found.lattice_points();
  LATTICED_ASSIGN_OR_RETURN(const auto tangents,
                            Continued(context, *found.lattice().map, std::move(given)));
  LATTICED_ASSIGN_OR_RETURN(auto answer, MakeAnswer(context, found, directions));
  LATTICED_ASSIGN_OR_RETURN(const auto sums, ReserveSums(context, found, directions));
  LATTICED_RETURN_IF_ERROR(found.Evaluate([&](PointEvaluator& points) {
    return points.ApplyJacobian(
        found.control_points(), tangents.vectors, found.normals,
        [&] { return CheckCancelled(context.call); }, answer->vectors);
  }));
  return PartsOf(found, directions, std::move(answer));
}

// Every rpc of the service: name, role, handler.
constexpr Rpc kCreatePointSet{"PointSetService/CreatePointSet", Role::kEdit};
constexpr UnaryMethod kListPointSets{Rpc{"PointSetService/ListPointSets", Role::kRead},
                                     ListPointSets};
constexpr UnaryMethod kDeletePointSet{Rpc{"PointSetService/DeletePointSet", Role::kEdit},
                                      DeletePointSet};
constexpr PartMethod kDeformPointSet{Rpc{"PointSetService/DeformPointSet", Role::kRead}, OpenDeform,
                                     Parts::kCopied, Lane::kLong};
constexpr PartMethod kApplyJacobian{Rpc{"PointSetService/ApplyJacobian", Role::kRead}, OpenJacobian,
                                    Parts::kCopied, Lane::kLong};
constexpr Rpc kApplyJacobianTranspose{"PointSetService/ApplyJacobianTranspose", Role::kRead};

// Every rpc takes and gives bytes (server/wire/message_bytes.h).
using P = v1::PointSetService;
using Sets = P::WithRawCallbackMethod_CreatePointSet<
    P::WithRawCallbackMethod_ListPointSets<P::WithRawCallbackMethod_DeletePointSet<P::Service>>>;
using PointSetServiceBase = P::WithRawCallbackMethod_DeformPointSet<
    P::WithRawCallbackMethod_ApplyJacobian<P::WithRawCallbackMethod_ApplyJacobianTranspose<Sets>>>;

class PointSetServiceImpl final : public PointSetServiceBase {
 public:
  using Context = grpc::CallbackServerContext;
  using Bytes = grpc::ByteBuffer;

  explicit PointSetServiceImpl(ServerEnv* env) : env_(env) {}

  grpc::ServerReadReactor<Bytes>* CreatePointSet(Context* context, Bytes* response) override {
    return NewCreatePointSet(kCreatePointSet, env_, context, response);
  }
  grpc::ServerUnaryReactor* ListPointSets(Context* context, const Bytes* request,
                                          Bytes* response) override {
    return kListPointSets.Run(env_, context, request, response);
  }
  grpc::ServerUnaryReactor* DeletePointSet(Context* context, const Bytes* request,
                                           Bytes* response) override {
    return kDeletePointSet.Run(env_, context, request, response);
  }
  grpc::ServerWriteReactor<Bytes>* DeformPointSet(Context* context, const Bytes* request) override {
    return kDeformPointSet.Run(env_, context, request);
  }
  grpc::ServerWriteReactor<Bytes>* ApplyJacobian(Context* context, const Bytes* request) override {
    return kApplyJacobian.Run(env_, context, request);
  }
  grpc::ServerReadReactor<Bytes>* ApplyJacobianTranspose(Context* context,
                                                         Bytes* response) override {
    return NewApplyJacobianTranspose(kApplyJacobianTranspose, env_, context, response);
  }

 private:
  ServerEnv* const env_;
};

}  // namespace

std::unique_ptr<grpc::Service> MakePointSetService(ServerEnv* env) {
  return std::make_unique<PointSetServiceImpl>(env);
}

}  // namespace latticed
