// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/in_process.h"

#include <grpcpp/grpcpp.h>

#include <thread>
#include <utility>

#include "absl/time/clock.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/backends.h"
#include "server/base/auth/authenticator.h"
#include "server/base/telemetry.h"
#include "server/edge/grpc_server.h"
#include "server/edge/metrics.h"
#include "server/net/tls_context.h"
#include "server/rpc/call.h"
#include "server/rpc/restore_stored.h"
#include "server/rpc/server_env.h"
#include "server/store/postgres_store.h"
#include "server/store/sqlite_store.h"
#include "server/stores/scene_registry.h"
#include "server/web/web_server.h"

namespace latticed {
namespace {

// Scenes are released by thousands in this time. While the store hangs, the rest of the drain must not wait for it.
constexpr absl::Duration kMostRetiring = absl::Seconds(3);

void WarnOfOpenPorts(const Options& options) {
  for (const auto& [flag, address] :
       {std::pair("--listen", options.listen), std::pair("--http", options.http)}) {
    if (address.empty() || IsLoopback(address)) continue;
    LogEvent(
        spdlog::level::warn,
        "other machines can connect: on a network that is not trusted, put a proxy in front that "
        "bounds headers, streams and rates, such as docker/haproxy.cfg",
        {{"flag", flag}, {"address", address}});
    return;
  }
}

absl::StatusOr<std::shared_ptr<Store>> OpenSharedStore(const Options& options) {
  LATTICED_ASSIGN_OR_RETURN(auto store, OpenPostgresStore({.url_file = options.store_url_file,
                                                           .mesh_store = options.mesh_store,
                                                           .s3_endpoint = options.s3_endpoint,
                                                           .s3_region = options.s3_region,
                                                           .name = options.advertise,
                                                           .lease = options.lease}));
  LogEvent(spdlog::level::info, "meshes, scenes and edits are kept, and shared with other servers",
           {{"meshes", options.mesh_store},
            {"name", options.advertise},
            {"lease", absl::FormatDuration(options.lease)}});
  return store;
}

// Null where nothing is kept.
absl::StatusOr<std::shared_ptr<Store>> OpenStore(const Options& options) {
  if (options.store == "postgres") return OpenSharedStore(options);
  if (options.data_dir.empty()) {
    LogEvent(spdlog::level::info, "meshes and scenes end with this server: --data-dir keeps them",
             {});
    return nullptr;
  }
  const bool full = options.durability == "full";
  LATTICED_ASSIGN_OR_RETURN(
      auto store, OpenSqliteStore({.folder = options.data_dir,
                                   .durability = full ? Durability::kFull : Durability::kAsync}));
  LogEvent(spdlog::level::info, "meshes, scenes and edits are kept",
           {{"folder", options.data_dir}, {"durability", options.durability}});
  if (!full) {
    LogEvent(spdlog::level::warn,
             "a loss of power may take edits of the last seconds that were acknowledged",
             {{"flag", "--durability"}});
  }
  return store;
}

}  // namespace

InProcessServer::InProcessServer() = default;

InProcessServer::~InProcessServer() { Stop(); }

absl::StatusOr<std::unique_ptr<InProcessServer>> InProcessServer::Start(Options options) {
  return Start(std::move(options), {});
}

absl::StatusOr<std::unique_ptr<InProcessServer>> InProcessServer::Start(
    Options options, std::vector<std::unique_ptr<Backend>> backends, std::shared_ptr<Store> store) {
  options.listen = "127.0.0.1:0";
  return ServeOn(std::move(options), std::move(backends), std::move(store));
}

absl::StatusOr<std::unique_ptr<InProcessServer>> InProcessServer::Serve(Options options) {
  return ServeOn(std::move(options), {}, nullptr);
}

absl::StatusOr<std::unique_ptr<InProcessServer>> InProcessServer::ServeOn(
    Options options, std::vector<std::unique_ptr<Backend>> backends, std::shared_ptr<Store> store) {
  LATTICED_RETURN_IF_ERROR(Validate(options));
  ConfigureLogging(options.log_level, options.log_format);
  LATTICED_ASSIGN_OR_RETURN(Authenticator authenticator, Authenticator::FromOptions(options));
  if (backends.empty()) {
    LATTICED_ASSIGN_OR_RETURN(backends, MakeBackends(options));
  }
  WarnOfOpenPorts(options);
  if (store == nullptr) {
    LATTICED_ASSIGN_OR_RETURN(store, OpenStore(options));
  }
  std::unique_ptr<InProcessServer> result(new InProcessServer);
  result->env_ = std::make_unique<ServerEnv>(std::move(options), std::move(backends),
                                             std::move(authenticator), std::move(store));
  LATTICED_RETURN_IF_ERROR(result->env_->ReadQuotas());
  LATTICED_RETURN_IF_ERROR(result->env_->audit.Open());
  if (result->env_->store != nullptr) {
    LATTICED_RETURN_IF_ERROR(RestoreStored(*result->env_));
  }
  LATTICED_ASSIGN_OR_RETURN(result->server_, GrpcServer::Start(result->env_.get()));
  LATTICED_RETURN_IF_ERROR(result->StartWeb());
  return result;
}

absl::Status InProcessServer::StartWeb() {
  if (env_->options.http.empty() && env_->options.admin.empty()) return absl::OkStatus();
  web::AdminHooks hooks;
  hooks.health = [env = env_.get()] { return env->Health(); };
  hooks.dropped_log_lines = DroppedLogLines;
  hooks.ready = [server = server_.get()] { return server->serving(); };
  hooks.metrics = [env = env_.get(), server = server_.get()](const ConnectionCounts& http) {
    return MetricsText(*env, server->connections(), http);
  };
  LATTICED_ASSIGN_OR_RETURN(
      auto web, web::WebServer::Start(env_->options, {server_->InProcessChannel(), env_->peer_key},
                                      std::move(hooks)));
  web_ = std::move(web);
  return absl::OkStatus();
}

std::shared_ptr<grpc::Channel> InProcessServer::channel() const {
  return grpc::CreateChannel(address(), grpc::InsecureChannelCredentials());
}

std::string InProcessServer::address() const { return server_->address(); }

std::string InProcessServer::http_address() const {
  return web_ == nullptr ? "" : web_->http_address();
}

std::string InProcessServer::admin_address() const {
  return web_ == nullptr ? "" : web_->admin_address();
}

std::string InProcessServer::backend_description() const {
  const Backend& backend = env_->backend();
  return fmt::format("{}: {}", backend.name(), backend.description());
}

std::string InProcessServer::metrics() const {
  return MetricsText(*env_, server_->connections(),
                     web_ == nullptr ? ConnectionCounts() : web_->connections());
}

absl::Status InProcessServer::Reload(const Options& options) {
  SetLogLevel(options.log_level);
  absl::Status renewed = env_->RenewTokens();
  renewed.Update(env_->ReadQuotas());
  renewed.Update(env_->audit.Open());
  LATTICED_ASSIGN_OR_RETURN(const auto tls, ReadTls(env_->options));
  if (tls == nullptr) return renewed;
  LATTICED_RETURN_IF_ERROR(server_->SetTls(*tls));
  if (web_ != nullptr) web_->SetTls(tls->context);
  return renewed;
}

Pulse InProcessServer::TakePulse() const { return env_->TakePulse(); }

void InProcessServer::Drain() {
  server_->SetServing(false);
  if (env_->store != nullptr && env_->store->shared()) {
    HandOver();
  } else {
    absl::SleepFor(env_->options.drain_delay);
    env_->drain.request_stop();
    const absl::Time deadline = absl::Now() + env_->options.drain_timeout;
    if (web_ != nullptr) web_->Drain(deadline);
    server_->Shutdown(deadline);
  }
  LogRefusalSums(*env_->calls, absl::InfiniteFuture());
}

// New connections are refused before the first scene is released. Whoever comes back then is sent to another server, by a
// proxy which noticed nothing else yet, and that server can claim the scene.
void InProcessServer::HandOver() {
  const absl::Time deadline = absl::Now() + env_->options.drain_timeout;
  const std::jthread calls([this, deadline] { server_->Shutdown(deadline); });
  const std::jthread pages([this, deadline] {
    if (web_ != nullptr) web_->Drain(deadline);
  });
  env_->scenes->Retire(kMostRetiring);
  env_->drain.request_stop();
}

void InProcessServer::Stop() {
  if (server_ == nullptr) return;
  env_->drain.request_stop();
  if (web_ != nullptr) web_->Stop();
  server_->Shutdown(absl::Now());
}

}  // namespace latticed
