// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/call.h"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <memory>
#include <utility>

#include "absl/time/clock.h"
#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/base/address.h"
#include "server/base/auth/tenant.h"
#include "server/base/random_id.h"
#include "server/base/telemetry.h"
#include "server/rpc/access/token_end.h"
#include "server/rpc/call_counts.h"
#include "server/rpc/server_env.h"
#include "server/store/store_errors.h"
#include "server/wire/grpc_status.h"

namespace latticed {
namespace {

constexpr char kRequestId[] = "latticed-request-id";
constexpr char kOwner[] = "latticed-owner";
constexpr char kForwardedFor[] = "x-forwarded-for";
constexpr size_t kRequestIdDigits = 16;   // of an id made here
constexpr size_t kTraceparentBytes = 55;  // 00-<32 hex>-<16 hex>-<2 hex>
constexpr uint32_t kDrainRetryMs = 1'000;

std::string Metadata(const grpc::CallbackServerContext& context, const char* key) {
  const auto& metadata = context.client_metadata();
  const auto found = metadata.find(key);
  if (found == metadata.end()) return "";
  return std::string(found->second.data(), found->second.size());
}

bool IsSaneId(const std::string& id) {
  const auto allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
           c == '_' || c == '.';
  };
  return !id.empty() && id.size() <= limits::kMaxRequestIdBytes &&
         std::all_of(id.begin(), id.end(), allowed);
}

// The name in the client's certificate, for callers whose token gives no name. Empty without a certificate.
std::string PeerName(const grpc::CallbackServerContext& context) {
  const auto auth = context.auth_context();
  if (auth == nullptr || !auth->IsPeerAuthenticated()) return "";
  const auto names = auth->GetPeerIdentity();
  return names.empty() ? "" : std::string(names.front().data(), names.front().size());
}

// The client's address as a trusted proxy names it: the last one of x-forwarded-for. Empty without one.
std::string ForwardedFor(const ServerEnv& env, const grpc::CallbackServerContext& context) {
  if (!env.options.trust_forwarded_for) return "";
  const auto [first, last] = context.client_metadata().equal_range(kForwardedFor);
  if (first == last) return "";
  const grpc::string_ref field = std::prev(last)->second;
  std::string ip(field.data(), field.size());
  ip.erase(0, ip.find_last_of(", ") + 1);
  if (!IsIp(ip)) return "";
  return ip.find(':') == std::string::npos ? fmt::format("ipv4:{}:0", ip)
                                           : fmt::format("ipv6:%5B{}%5D:0", ip);
}

// Calls of server/web come through this process's own channel. They have the client's address in their metadata.
std::string PeerAddress(const ServerEnv& env, const grpc::CallbackServerContext& context) {
  const std::string named = Metadata(context, env.peer_key.c_str());
  return named.empty() ? context.peer() : named;
}

CallInfo Describe(ServerEnv& env, grpc::CallbackServerContext* context, const Rpc& rpc) {
  CallInfo call;
  call.rpc = rpc;
  call.context = context;
  call.start_time = absl::Now();
  call.arrival = std::chrono::steady_clock::now();
  call.counts = env.calls.get();
  ++call.counts->Of(rpc.name).started;
  call.write = env.stalled_calls.Add(context);
  call.peer = ForwardedFor(env, *context);
  call.is_forwarded = !call.peer.empty();
  call.is_proxied = !Metadata(*context, kForwardedFor).empty() &&
                    Metadata(*context, env.peer_key.c_str()).empty();
  if (!call.is_forwarded) call.peer = PeerAddress(env, *context);
  const std::string asked_id = Metadata(*context, kRequestId);
  call.request_id = IsSaneId(asked_id) ? asked_id : NewRandomId().substr(0, kRequestIdDigits);
  const std::string traceparent = Metadata(*context, "traceparent");
  if (traceparent.size() == kTraceparentBytes && IsSaneId(traceparent)) {
    call.traceparent = traceparent;
  }
  NoteScene(call, Metadata(*context, "latticed-scene"));
  context->AddInitialMetadata(kRequestId, call.request_id);
  context->AddInitialMetadata("latticed-node", env.node);
  context->AddTrailingMetadata(kRequestId, call.request_id);
  context->AddTrailingMetadata("latticed-node", env.node);
  return call;
}

absl::StatusOr<Caller> Authenticate(ServerEnv& env, const CallInfo& call) {
  const std::string authorization = Metadata(*call.context, "authorization");
  // Also where everybody is admitted: who has a share's token wants that scene, and no more.
  const std::string_view token = BearerToken(authorization);
  if (ShareStore::IsToken(token)) {
    // Nobody guesses 256 bits, and many may open one old link from one address: none has to wait.
    return env.shares.CallerOf(token, call.start_time);
  }
  absl::StatusOr<Caller> caller = env.authenticator()->Authenticate(authorization);
  if (caller.ok() || authorization.empty()) return caller;
  const absl::Duration wait =
      env.wrong_tokens.NoteWrong(NetworkOf(IpOf(call.peer)), call.start_time);
  if (wait == absl::ZeroDuration()) return caller;
  return error::Throttled("too many wrong tokens came from this address", wait);
}

absl::Status Admit(ServerEnv& env, CallInfo& call) {
  LATTICED_ASSIGN_OR_RETURN(call.caller, Authenticate(env, call));
  // Not a guess of a token, so nobody has to wait.
  LATTICED_RETURN_IF_ERROR(CheckTokenTime(call.caller, call.start_time));
  if (call.caller.name.empty()) call.caller.name = PeerName(*call.context);
  LATTICED_RETURN_IF_ERROR(CheckRole(call.caller, call.rpc));
  // Two tenants may each have a caller of this name.
  const std::string& name = call.caller.name;
  call.account = env.callers.Of(name.empty() ? name : TenantKey(call.caller.tenant, name),
                                call.peer, call.is_forwarded);
  if (!call.account->TakeCall(call.start_time)) {
    return error::Throttled(
        fmt::format("a caller may make {} calls a second", limits::kMaxCallsPerSecond),
        absl::Seconds(1));
  }
  return CheckDraining(env);
}

// The trace's id, 32 hex digits; empty without a traceparent.
std::string TraceId(const std::string& traceparent) {
  constexpr size_t kBegin = 3, kDigits = 32;
  return traceparent.empty() ? "" : traceparent.substr(kBegin, kDigits);
}

spdlog::level::level_enum LevelOf(grpc::StatusCode code) {
  switch (code) {
    case grpc::StatusCode::OK:
    case grpc::StatusCode::CANCELLED:
    case grpc::StatusCode::DEADLINE_EXCEEDED:
      return spdlog::level::debug;
    case grpc::StatusCode::UNKNOWN:
    case grpc::StatusCode::INTERNAL:
    case grpc::StatusCode::DATA_LOSS:
      return spdlog::level::err;
    default:
      return spdlog::level::info;
  }
}

void Count(const CallInfo& call, const grpc::Status& status, absl::Duration taken) {
  RpcCounts& rpc = call.counts->Of(call.rpc.name);
  ++rpc.finished[static_cast<size_t>(status.error_code())];
  rpc.duration.Observe(taken);
  if (!status.ok()) call.counts->NoteRefusal(ReasonOf(status));
}

std::string CodeName(int code) {
  return absl::StatusCodeToString(static_cast<absl::StatusCode>(code));
}

}  // namespace

absl::Status BeginCall(ServerEnv& env, grpc::CallbackServerContext* context, const Rpc& rpc,
                       CallInfo& call) {
  call = Describe(env, context, rpc);
  return Admit(env, call);
}

absl::Status CheckDraining(const ServerEnv& env) {
  if (!env.drain.stop_requested()) return absl::OkStatus();
  return error::Unavailable("DRAINING", "this server is shutting down; call another or come back",
                            kDrainRetryMs);
}

void NoteScene(CallInfo& call, const std::string& scene) {
  if (IsSaneId(scene)) call.scene = scene;
}

void NoteOwner(const ServerEnv& env, const CallInfo& call, const absl::Status& found) {
  if (env.options.advertise.empty()) return;
  std::string owner = env.options.advertise;
  if (error::IsSceneMoved(found)) owner = error::DetailsOf(found).metadata["owner"];
  if (found.ok() || error::IsSceneMoved(found)) {
    if (!owner.empty()) call.context->AddInitialMetadata(kOwner, owner);
  }
}

void LogFinished(const CallInfo& call, const grpc::Status& status) {
  const absl::Duration taken = absl::Now() - call.start_time;
  Count(call, status, taken);
  const spdlog::level::level_enum level = LevelOf(status.error_code());
  if (level == spdlog::level::info &&
      !call.counts->refusal_log().Note(WithoutPort(call.peer), call.rpc.name, status.error_code(),
                                       call.start_time + taken)) {
    return;
  }
  LogEvent(level, "call finished",
           {{"rpc", std::string(call.rpc.name)},
            {"code", CodeName(status.error_code())},
            {"ms", fmt::format("{:.3f}", absl::ToDoubleMilliseconds(taken))},
            {kRequestId, call.request_id},
            {"caller", call.caller.name},
            {"tenant", call.caller.tenant},
            {"peer", call.peer},
            {"scene", call.scene},
            {"traceparent", call.traceparent},
            {"trace_id", TraceId(call.traceparent)},
            {"error", status.error_message()}});
}

void LogRefusalSums(CallCounts& counts, absl::Time now) {
  for (const RefusalLog::Sum& sum : counts.refusal_log().TakeEnded(now)) {
    LogEvent(spdlog::level::info, "more calls were refused",
             {{"calls", fmt::to_string(sum.count)},
              {"rpc", sum.rpc},
              {"code", CodeName(sum.code)},
              {"peer", sum.address}});
  }
}

absl::Status CheckSceneMetadata(const CallInfo& call, std::string_view scene_id) {
  const std::string routed = Metadata(*call.context, "latticed-scene");
  if (routed.empty() || routed == scene_id) return absl::OkStatus();
  return error::InvalidField(
      "scene",
      fmt::format("metadata latticed-scene is '{}', the request names '{}'", routed, scene_id),
      "SCENE_MISMATCH");
}

absl::Status CheckCancelled(const CallInfo& call) {
  // The deadline is checked here too, because gRPC cancels a call only some time after it.
  if (std::chrono::system_clock::now() >= call.context->deadline()) {
    return absl::DeadlineExceededError("the caller's deadline has passed");
  }
  return call.context->IsCancelled() ? absl::CancelledError("the caller cancelled")
                                     : absl::OkStatus();
}

absl::StatusOr<MemoryReservation> AdmitRequest(const ServerEnv& env, const CallInfo& call,
                                               const google::protobuf::Message& request) {
  return env.requests->Reserve("the request", limits::kCallBytes + request.SpaceUsedLong(),
                               call.account->requests);
}

uint64_t ReplyBytes(const google::protobuf::Message& reply) {
  return reply.SpaceUsedLong() + reply.ByteSizeLong();
}

// A reservation of 0 bytes is always granted.
void ReplyRoom::Open(const ServerEnv& env, const CallInfo& call) {
  room_ = *env.replies->Reserve("the reply", 0, call.account->replies);
}

absl::Status ReplyRoom::Hold(uint64_t bytes) {
  if (bytes <= std::max(limits::kSmallReplyBytes, room_.bytes())) return absl::OkStatus();
  return room_.Resize("the reply", bytes);
}

}  // namespace latticed
