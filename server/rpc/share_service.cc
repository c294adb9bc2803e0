// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

#include <memory>
#include <string>
#include <utility>

#include "absl/time/clock.h"
#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "latticed/v1/share.grpc.pb.h"
#include "server/base/auth/tenant.h"
#include "server/rpc/access/audit.h"
#include "server/rpc/access/tenant_access.h"
#include "server/rpc/method.h"
#include "server/rpc/server_env.h"
#include "server/rpc/services.h"
#include "server/rpc/watch_request.h"
#include "server/stores/share_store.h"
#include "server/wire/enum_table.h"
#include "server/wire/time_converters.h"

namespace latticed {
namespace {

constexpr EnumTable<v1::ShareRole, Role, 2> kShareRoles = {
    {{v1::SHARE_ROLE_READ, Role::kRead}, {v1::SHARE_ROLE_EDIT, Role::kEdit}}};

v1::Share ToProto(const Share& share) {
  v1::Share out;
  out.set_share_id(share.id);
  out.set_scene(std::string(IdOf(share.scene)));
  out.set_role(WriteEnum(kShareRoles, share.role));
  out.set_creator(share.creator);
  SetTime(share.create_time, *out.mutable_create_time());
  SetTime(share.expire_time, *out.mutable_expire_time());
  return out;
}

absl::StatusOr<absl::Duration> TtlOf(const v1::CreateShareRequest& request) {
  if (!request.has_ttl()) return absl::Seconds(limits::kDefaultShareSeconds);
  const auto& ttl = request.ttl();
  const absl::Duration asked = absl::Seconds(ttl.seconds()) + absl::Nanoseconds(ttl.nanos());
  LATTICED_RETURN_IF_ERROR(error::CheckRange("ttl", absl::ToDoubleSeconds(asked), 1,
                                             static_cast<double>(limits::kMaxShareSeconds)));
  return asked;
}

// A share must be revocable while its scene cannot be woken: it is damaged, or there is no memory for it.
absl::Status CheckSceneExists(const CallContext& context, const std::string& scene) {
  const absl::Status found = FindScene(context.env, context.call, scene).status();
  const bool is_there = absl::IsDataLoss(found) || absl::IsResourceExhausted(found);
  return is_there ? absl::OkStatus() : found;
}

// As its audit shows it.
AuditFields FieldsOf(const Share& share) {
  return {{"scene", std::string(IdOf(share.scene))},
          {"share", share.id},
          {"role", std::string(RoleName(share.role))},
          {"expires", absl::FormatTime(absl::RFC3339_sec, share.expire_time, absl::UTCTimeZone())}};
}

absl::Status CreateShare(const CallContext& context, const v1::CreateShareRequest& request,
                         v1::CreateShareResponse& response) {
  if (request.role() == v1::SHARE_ROLE_UNSPECIFIED) {
    return error::InvalidField("role", "is required");
  }
  LATTICED_ASSIGN_OR_RETURN(const Role role, ReadEnum(kShareRoles, request.role(), "role"));
  LATTICED_ASSIGN_OR_RETURN(const absl::Duration ttl, TtlOf(request));
  LATTICED_ASSIGN_OR_RETURN(const auto scene,
                            FindScene(context.env, context.call, request.scene()));
  const absl::Time now = absl::Now();
  LATTICED_ASSIGN_OR_RETURN(auto made,
                            context.env.shares.Create({.scene = scene->id(),
                                                       .scene_create_time = scene->create_time(),
                                                       .mesh = scene->config().mesh_id,
                                                       .role = role,
                                                       .creator = context.call.caller.name,
                                                       .expire_time = now + ttl},
                                                      now));
  // Who deletes the scene meanwhile does not know of the share yet.
  if (const absl::Status ended = scene->ended(); absl::IsNotFound(ended)) {
    (void)context.env.shares.Revoke(scene->id(), made.share.id);
    return ToldById(ended, "scene", request.scene());
  }
  Audit(context.env, context.call, "scene_shared", FieldsOf(made.share));
  *response.mutable_share() = ToProto(made.share);
  response.set_token(std::move(made.token));
  return absl::OkStatus();
}

absl::Status ListShares(const CallContext& context, const v1::ListSharesRequest& request,
                        v1::ListSharesResponse& response) {
  LATTICED_RETURN_IF_ERROR(CheckSceneExists(context, request.scene()));
  const absl::Time now = absl::Now();
  for (const Share& share : context.env.shares.Of(KeyFor(context.call, request.scene()))) {
    if (share.expire_time > now) *response.add_shares() = ToProto(share);
  }
  return absl::OkStatus();
}

absl::Status RevokeShare(const CallContext& context, const v1::RevokeShareRequest& request,
                         v1::RevokeShareResponse&) {
  LATTICED_RETURN_IF_ERROR(CheckSceneExists(context, request.scene()));
  LATTICED_RETURN_IF_ERROR(
      context.env.shares.Revoke(KeyFor(context.call, request.scene()), request.share_id()));
  Audit(context.env, context.call, "share_revoked",
        {{"scene", request.scene()}, {"share", request.share_id()}});
  return absl::OkStatus();
}

// Every rpc of the service: name, role, handler.
constexpr UnaryMethod kCreateShare{Rpc{"ShareService/CreateShare", Role::kEdit}, CreateShare,
                                   Lane::kLong};
constexpr UnaryMethod kListShares{Rpc{"ShareService/ListShares", Role::kEdit}, ListShares};
constexpr UnaryMethod kRevokeShare{Rpc{"ShareService/RevokeShare", Role::kEdit}, RevokeShare,
                                   Lane::kLong};

// Every rpc takes and gives bytes (server/wire/message_bytes.h).
using H = v1::ShareService;
using ShareServiceBase = H::WithRawCallbackMethod_CreateShare<
    H::WithRawCallbackMethod_ListShares<H::WithRawCallbackMethod_RevokeShare<H::Service>>>;

class ShareServiceImpl final : public ShareServiceBase {
 public:
  explicit ShareServiceImpl(ServerEnv* env) : env_(env) {}

  grpc::ServerUnaryReactor* CreateShare(grpc::CallbackServerContext* context,
                                        const grpc::ByteBuffer* request,
                                        grpc::ByteBuffer* response) override {
    return kCreateShare.Run(env_, context, request, response);
  }
  grpc::ServerUnaryReactor* ListShares(grpc::CallbackServerContext* context,
                                       const grpc::ByteBuffer* request,
                                       grpc::ByteBuffer* response) override {
    return kListShares.Run(env_, context, request, response);
  }
  grpc::ServerUnaryReactor* RevokeShare(grpc::CallbackServerContext* context,
                                        const grpc::ByteBuffer* request,
                                        grpc::ByteBuffer* response) override {
    return kRevokeShare.Run(env_, context, request, response);
  }

 private:
  ServerEnv* const env_;
};

}  // namespace

std::unique_ptr<grpc::Service> MakeShareService(ServerEnv* env) {
  return std::make_unique<ShareServiceImpl>(env);
}

}  // namespace latticed
