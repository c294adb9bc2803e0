// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/library/latticed_client.h"

#include <functional>
#include <random>
#include <utility>

#include "client/cpp/library/retries/with_retries.h"
#include "client/cpp/library/status.h"
#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "grpc/health/v1/health.grpc.pb.h"
#include "grpcpp/create_channel.h"
#include "grpcpp/security/credentials.h"

namespace latticed::client {
namespace {

using MeshStub = v1::MeshService::Stub;
using SceneStub = v1::SceneService::Stub;

std::string RandomHexDigits() {
  std::random_device random;
  return fmt::format("{:08x}{:08x}{:08x}{:08x}", random(), random(), random(), random());
}

}  // namespace

std::string RandomSceneId() { return RandomHexDigits(); }

std::string RandomEditorId() {
  std::string hex = RandomHexDigits();
  hex[12] = '4';                                       // version: random
  hex[16] = "89ab"[static_cast<size_t>(hex[16]) % 4];  // variant: RFC 4122
  return fmt::format("{}-{}-{}-{}-{}", hex.substr(0, 8), hex.substr(8, 4), hex.substr(12, 4),
                     hex.substr(16, 4), hex.substr(20));
}

std::unique_ptr<Client> Client::Connect(const Connection& connection, std::stop_token stop) {
  std::shared_ptr<grpc::ChannelCredentials> credentials = grpc::InsecureChannelCredentials();
  if (connection.tls || !connection.tls_ca_pem.empty() || !connection.tls_cert_pem.empty()) {
    credentials = grpc::SslCredentials(
        {connection.tls_ca_pem, connection.tls_key_pem, connection.tls_cert_pem});
  }
  grpc::ChannelArguments arguments;
  // By default gRPC pauses 1 s before it reconnects, and later up to two minutes. Calls fail meanwhile,
  // so its pauses are shorter than ours: each of our attempts is then one to connect.
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 100);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 500);
  // How long one attempt to connect may take: by default 20 s, which an unplugged network would cost.
  arguments.SetInt(GRPC_ARG_MIN_RECONNECT_BACKOFF_MS, 3'000);
  if (connection.alone) arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  std::string target = connection.address;
  if (target.find(',') != std::string::npos) {
    target = (target.starts_with('[') ? "ipv6:" : "ipv4:") + target;
    arguments.SetLoadBalancingPolicyName("round_robin");
  }
  return std::make_unique<Client>(
      grpc::CreateCustomChannel(target, credentials, Patient(arguments)), connection.token,
      std::move(stop), connection.retry_for, connection.observer,
      grpc::CreateCustomChannel(target, credentials, Attentive(arguments)));
}

Client::Client(std::shared_ptr<grpc::Channel> channel, std::string token, std::stop_token stop,
               absl::Duration retry_for, ReachabilityObserver observer,
               const std::shared_ptr<grpc::Channel>& stream_channel)
    : channel_(std::move(channel)),
      stream_channel_(stream_channel == nullptr ? channel_ : stream_channel),
      token_(std::move(token)),
      stop_(std::move(stop)),
      reachability_(std::make_unique<Reachability>(retry_for, std::move(observer))),
      server_(v1::ServerService::NewStub(channel_)),
      meshes_(v1::MeshService::NewStub(channel_)),
      scenes_(v1::SceneService::NewStub(channel_)),
      streams_(v1::SceneService::NewStub(stream_channel_)),
      backups_(v1::BackupService::NewStub(channel_)),
      shares_(v1::ShareService::NewStub(channel_)),
      points_(v1::PointSetService::NewStub(channel_)) {}

std::unique_ptr<grpc::ClientContext> Client::NewContext(const std::string& scene) const {
  auto context = std::make_unique<grpc::ClientContext>();
  if (!token_.empty()) context->AddMetadata("authorization", "Bearer " + token_);
  if (!scene.empty()) context->AddMetadata("latticed-scene", scene);
  return context;
}

template <typename Stub, typename Request, typename Response>
absl::StatusOr<Response> Client::CallOnce(Stub& stub, Method<Stub, Request, Response> method,
                                          const Request& request, const std::string& scene,
                                          const std::stop_token& stop) {
  const auto context = NewContext(scene);
  const std::stop_callback cancel(stop, [&context] { context->TryCancel(); });
  Response response;
  const grpc::Status status = (stub.*method)(context.get(), request, &response);
  if (!status.ok()) return FromGrpc(status, *context);
  return response;
}

template <typename Stub, typename Request, typename Response>
absl::StatusOr<Response> Client::Call(Stub& stub, Method<Stub, Request, Response> method,
                                      const Request& request, const std::string& scene,
                                      const std::stop_token& stop) {
  absl::StatusOr<Response> response;
  LATTICED_RETURN_IF_ERROR(WithRetries(reachability_.get(), *channel_, stop_, [&] {
    response = CallOnce(stub, method, request, scene, stop);
    return response.status();
  }));
  return response;
}

absl::StatusOr<v1::ServerInfo> Client::GetServerInfo(uint32_t probe_bytes) {
  v1::GetServerInfoRequest request;
  request.set_probe_bytes(probe_bytes);
  return Call(*server_, &v1::ServerService::Stub::GetServerInfo, request, "", stop_);
}

absl::Status Client::CheckHealth() {
  using grpc::health::v1::Health;
  using grpc::health::v1::HealthCheckResponse;
  const auto stub = Health::NewStub(channel_);
  // Not repeated: the caller wants the server's health at this moment.
  LATTICED_ASSIGN_OR_RETURN(const auto response,
                            CallOnce(*stub, &Health::Stub::Check, {}, "", stop_));
  if (response.status() == HealthCheckResponse::SERVING) return absl::OkStatus();
  return absl::UnavailableError(fmt::format(
      "the server says {}", HealthCheckResponse::ServingStatus_Name(response.status())));
}

absl::StatusOr<v1::Mesh> Client::GetMesh(const std::string& id) {
  v1::GetMeshRequest request;
  request.set_mesh(id);
  return Call(*meshes_, &MeshStub::GetMesh, request, "", stop_);
}

absl::StatusOr<std::vector<v1::Mesh>> Client::ListMeshes(const std::string& filter) {
  v1::ListMeshesRequest request;
  request.set_filter(filter);
  std::vector<v1::Mesh> meshes;
  do {
    LATTICED_ASSIGN_OR_RETURN(const auto page,
                              Call(*meshes_, &MeshStub::ListMeshes, request, "", stop_));
    meshes.insert(meshes.end(), page.meshes().begin(), page.meshes().end());
    request.set_page_token(page.next_page_token());
  } while (!request.page_token().empty());
  return meshes;
}

absl::Status Client::DeleteMesh(const std::string& mesh, bool force) {
  v1::DeleteMeshRequest request;
  request.set_mesh(mesh);
  request.set_force(force);
  return CallOnce(*meshes_, &MeshStub::DeleteMesh, request, "", /*stop=*/{}).status();
}

absl::StatusOr<v1::Scene> Client::CreateScene(v1::CreateSceneRequest request) {
  if (stop_.stop_requested()) return Stopped();
  if (request.scene_id().empty()) request.set_scene_id(RandomSceneId());
  return Call(*scenes_, &SceneStub::CreateScene, request, request.scene_id(), /*stop=*/{});
}

absl::StatusOr<v1::Scene> Client::GetScene(const std::string& id) {
  v1::GetSceneRequest request;
  request.set_scene(id);
  return Call(*scenes_, &SceneStub::GetScene, request, id, stop_);
}

absl::StatusOr<std::vector<v1::Scene>> Client::ListScenes(const std::string& filter) {
  v1::ListScenesRequest request;
  request.set_filter(filter);
  std::vector<v1::Scene> scenes;
  do {
    LATTICED_ASSIGN_OR_RETURN(const auto page,
                              Call(*scenes_, &SceneStub::ListScenes, request, "", stop_));
    scenes.insert(scenes.end(), page.scenes().begin(), page.scenes().end());
    request.set_page_token(page.next_page_token());
  } while (!request.page_token().empty());
  return scenes;
}

absl::Status Client::DeleteScene(const std::string& scene) {
  v1::DeleteSceneRequest request;
  request.set_scene(scene);
  return CallOnce(*scenes_, &SceneStub::DeleteScene, request, scene, /*stop=*/{}).status();
}

// Tried once: each attempt that reached the server would have made a share.
absl::StatusOr<std::vector<v1::PointSet>> Client::ListPointSets(const std::string& scene) {
  v1::ListPointSetsRequest request;
  request.set_scene(scene);
  LATTICED_ASSIGN_OR_RETURN(
      const auto list,
      Call(*points_, &v1::PointSetService::Stub::ListPointSets, request, scene, stop_));
  return std::vector<v1::PointSet>(list.point_sets().begin(), list.point_sets().end());
}

absl::Status Client::DeletePointSet(const std::string& scene, const std::string& point_set) {
  v1::DeletePointSetRequest request;
  request.set_scene(scene);
  request.set_point_set(point_set);
  return CallOnce(*points_, &v1::PointSetService::Stub::DeletePointSet, request, scene, /*stop=*/{})
      .status();
}

absl::StatusOr<v1::CreateShareResponse> Client::CreateShare(const v1::CreateShareRequest& request) {
  return CallOnce(*shares_, &v1::ShareService::Stub::CreateShare, request, request.scene(), stop_);
}

absl::StatusOr<std::vector<v1::Share>> Client::ListShares(const std::string& scene) {
  v1::ListSharesRequest request;
  request.set_scene(scene);
  LATTICED_ASSIGN_OR_RETURN(
      const auto list, Call(*shares_, &v1::ShareService::Stub::ListShares, request, scene, stop_));
  return std::vector<v1::Share>(list.shares().begin(), list.shares().end());
}

absl::Status Client::RevokeShare(const std::string& scene, const std::string& share) {
  v1::RevokeShareRequest request;
  request.set_scene(scene);
  request.set_share_id(share);
  return CallOnce(*shares_, &v1::ShareService::Stub::RevokeShare, request, scene, /*stop=*/{})
      .status();
}

absl::StatusOr<v1::LatticeState> Client::GetLattice(const std::string& scene, uint32_t lattice) {
  v1::GetLatticeRequest request;
  request.set_lattice(lattice);
  request.set_scene(scene);
  return Call(*scenes_, &SceneStub::GetLattice, request, scene, stop_);
}

absl::StatusOr<v1::EditResult> Client::ApplyEdits(const v1::EditBatch& batch) {
  return Call(*scenes_, &SceneStub::ApplyEdits, batch, batch.scene(), stop_);
}

absl::StatusOr<v1::EvaluatePointsResponse> Client::EvaluatePoints(
    const v1::EvaluatePointsRequest& request) {
  return Call(*scenes_, &SceneStub::EvaluatePoints, request, request.scene(), stop_);
}

absl::StatusOr<v1::FoldReport> Client::CertifyFolds(const v1::CertifyFoldsRequest& request) {
  return Call(*scenes_, &SceneStub::CertifyFolds, request, request.scene(), stop_);
}

absl::StatusOr<v1::SurfacePoint> Client::Pick(const v1::PickRequest& request) {
  return Call(*scenes_, &SceneStub::Pick, request, request.scene(), stop_);
}

absl::StatusOr<v1::MeasureSceneResponse> Client::MeasureScene(
    const v1::MeasureSceneRequest& request) {
  return Call(*scenes_, &SceneStub::MeasureScene, request, request.scene(), stop_);
}

void Client::WatchStreamSockets() {
  if (stream_channel_ == channel_) return;
  std::call_once(has_streams_, [this] { stream_sockets_.emplace(stream_channel_); });
}

absl::StatusOr<std::unique_ptr<WatchStream>> Client::Watch(v1::WatchRequest watch,
                                                           EventObserver observer) {
  WatchStreamSockets();
  return WatchStream::Open(this, std::move(watch), std::move(observer));
}

absl::StatusOr<std::unique_ptr<DeformStream>> Client::Deform(v1::WatchRequest watch,
                                                             EventObserver observer) {
  WatchStreamSockets();
  return DeformStream::Open(this, std::move(watch), std::move(observer));
}

}  // namespace latticed::client
