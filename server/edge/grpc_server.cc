// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/edge/grpc_server.h"

#include <google/protobuf/stubs/logging.h>
#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/health_check_service_interface.h>
#include <grpcpp/resource_quota.h>
#include <grpcpp/security/tls_certificate_provider.h>
#include <grpcpp/security/tls_credentials_options.h>

#include <mutex>
#include <utility>
#include <vector>

#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/base/telemetry.h"
#include "server/net/tls_context.h"
#include "server/rpc/services.h"
#include "server/stores/scene_registry.h"

namespace latticed {
namespace {

// Clients may ping this often, also an idle connection. Those of latticed do so after about a second.
constexpr int kMinClientPingMs = 500;
constexpr const char* kServiceNames[] = {
    "latticed.v1.MeshService",   "latticed.v1.SceneService", "latticed.v1.ServerService",
    "latticed.v1.BackupService", "latticed.v1.ShareService", "latticed.v1.PointSetService"};

// gRPC looks at its files once a second. While key and certificate do not fit together, as between the renewals of two
// files, it would serve nobody. So its files are copies in memory of what was found to fit.
std::shared_ptr<grpc::ServerCredentials> Credentials(const Options& options,
                                                     const MemoryFile& identity,
                                                     const MemoryFile& client_ca) {
  constexpr unsigned kReadAgainSeconds = 1;
  if (options.tls_cert.empty()) return grpc::InsecureServerCredentials();
  const bool asks_clients = !options.tls_client_ca.empty();
  grpc::experimental::TlsServerCredentialsOptions tls(
      std::make_shared<grpc::experimental::FileWatcherCertificateProvider>(
          identity.path(), identity.path(), asks_clients ? client_ca.path() : "",
          kReadAgainSeconds));
  tls.watch_identity_key_cert_pairs();
  if (asks_clients) {
    tls.watch_root_certs();
    tls.set_cert_request_type(GRPC_SSL_REQUEST_AND_REQUIRE_CLIENT_CERTIFICATE_AND_VERIFY);
  }
  return grpc::experimental::TlsServerCredentials(tls);
}

// Settings of the process, made once, before the first server is built.
void EnablePlugins() {
  static std::once_flag once;
  std::call_once(once, [] {
    // Protobuf would write a line for each text that is not UTF-8, and wait until somebody has read it.
    google::protobuf::SetLogHandler(nullptr);
    grpc::EnableDefaultHealthCheckService(true);
    grpc::reflection::InitProtoReflectionServerBuilderPlugin();
  });
}

// Takes gRPC reflection out of one server: the library adds it to all servers of a process. A reflection stream
// blocks one of gRPC's threads, so it is not for strangers.
class WithoutReflection final : public grpc::ServerBuilderOption {
 public:
  void UpdateArguments(grpc::ChannelArguments*) override {}
  void UpdatePlugins(std::vector<std::unique_ptr<grpc::ServerBuilderPlugin>>* plugins) override {
    std::erase_if(*plugins,
                  [](const auto& plugin) { return plugin->name() == "proto_server_reflection"; });
  }
};

void Configure(const Options& options, grpc::ServerBuilder& builder) {
  // When the quota is short, gRPC shrinks flow-control windows, then ends streams with RESOURCE_EXHAUSTED.
  grpc::ResourceQuota quota("latticed");
  quota.Resize(options.transport_memory_bytes);
  quota.SetMaxThreads(limits::kMaxGrpcThreads);
  builder.SetResourceQuota(quota);
  const bool local =
      IsLoopback(options.listen) && (options.http.empty() || IsLoopback(options.http));
  if (!options.reflection && !local) {
    builder.SetOption(std::make_unique<WithoutReflection>());
  }
  // No compression: gRPC decompresses a message before it compares its size with the limit.
  builder.AddChannelArgument(GRPC_COMPRESSION_CHANNEL_ENABLED_ALGORITHMS_BITSET,
                             1 << GRPC_COMPRESS_NONE);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS, limits::kMaxCallsPerConnection);
  builder.AddChannelArgument(GRPC_ARG_MAX_METADATA_SIZE, static_cast<int>(limits::kMaxHeaderBytes));
  builder.SetMaxReceiveMessageSize(static_cast<int>(limits::kMaxMessageBytes));
  builder.AddChannelArgument(GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS, limits::kHandshakeMs);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONNECTION_IDLE_MS, limits::kIdleConnectionMs);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS,
                             kMinClientPingMs);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, limits::kKeepaliveMs);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, limits::kKeepaliveTimeoutMs);
}

}  // namespace

absl::StatusOr<std::unique_ptr<GrpcServer>> GrpcServer::Start(ServerEnv* env) {
  EnablePlugins();
  const Options& options = env->options;
  std::unique_ptr<GrpcServer> result(new GrpcServer(env));
  LATTICED_ASSIGN_OR_RETURN(const auto tls, ReadTls(options));
  if (tls != nullptr) {
    LATTICED_RETURN_IF_ERROR(result->SetTls(*tls));
  }
  auto credentials = Credentials(options, result->identity_, result->client_ca_);
  result->services_.push_back(MakeServerService(env));
  result->services_.push_back(MakeMeshService(env));
  result->services_.push_back(MakeSceneService(env));
  result->services_.push_back(MakeBackupService(env));
  result->services_.push_back(MakeShareService(env));
  result->services_.push_back(MakePointSetService(env));

  grpc::ServerBuilder builder;
  Configure(options, builder);
  std::unique_ptr<GrpcListener::Acceptor> acceptor;
  if (IsUnixSocket(options.listen)) {
    builder.AddListeningPort(options.listen, credentials);
  } else {
    using FromSocket = grpc::ServerBuilder::experimental_type::ExternalConnectionType;
    acceptor = builder.experimental().AddExternalConnectionAcceptor(FromSocket::FROM_FD,
                                                                    std::move(credentials));
  }
  for (const auto& service : result->services_) builder.RegisterService(service.get());
  result->server_ = builder.BuildAndStart();
  if (result->server_ == nullptr) {
    return absl::UnavailableError(
        fmt::format("--listen: cannot serve on '{}': can the socket be made?", options.listen));
  }
  if (acceptor != nullptr) {
    LATTICED_ASSIGN_OR_RETURN(result->listener_, GrpcListener::Open(options, std::move(acceptor)));
  }
  result->SetServing(true);
  env->scenes->health().SetObserver(
      [server = result.get()](const absl::Status& why) { server->OnDeviceLost(why); });
  return result;
}

GrpcServer::GrpcServer(ServerEnv* env) : env_(env) {}

absl::Status GrpcServer::SetTls(const Tls& tls) {
  if (!tls.client_ca.empty()) {
    LATTICED_RETURN_IF_ERROR(client_ca_.Write(tls.client_ca));
  }
  return identity_.Write(tls.key + tls.certificate);
}

GrpcServer::~GrpcServer() {
  env_->scenes->health().SetObserver(nullptr);
  Shutdown(absl::InfinitePast());
}

void GrpcServer::OnDeviceLost(const absl::Status& why) {
  LogEvent(
      spdlog::level::critical, "device lost, not serving any more",
      {{"backend", std::string(env_->backend().name())}, {"error", std::string(why.message())}});
  SetServing(false);
}

std::shared_ptr<grpc::Channel> GrpcServer::InProcessChannel() {
  return server_->InProcessChannel(grpc::ChannelArguments());
}

void GrpcServer::SetServing(bool serving) {
  serving_ = serving;
  grpc::HealthCheckServiceInterface* health = server_->GetHealthCheckService();
  health->SetServingStatus(serving);
  for (const char* name : kServiceNames) health->SetServingStatus(name, serving);
}

std::string GrpcServer::address() const {
  return listener_ == nullptr ? env_->options.listen : listener_->address();
}

ConnectionCounts GrpcServer::connections() const {
  return listener_ == nullptr ? ConnectionCounts() : listener_->counts();
}

void GrpcServer::Shutdown(absl::Time deadline) {
  if (listener_ != nullptr) listener_->Close();
  if (server_ != nullptr) server_->Shutdown(absl::ToChronoTime(deadline));
}

}  // namespace latticed
