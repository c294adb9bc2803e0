// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The C++ client of latticed: one object per server, one function per rpc. It uploads in parts,
// reads all pages of lists, makes scene ids and routing metadata, returns whole updates, and
// resumes streams (stream.h). While the server does not answer, it makes a call again for 30 s
// (attempts.h), but a deletion only once: a second one would not find what the first has deleted.
//
//   auto client = Client::Connect({.address = "127.0.0.1:50151"});
//   auto mesh = client->UploadMesh(bytes, header);
//   auto scene = client->CreateScene(create);         // create.mesh = mesh->id()
//   auto surface = client->GetUpdate(get);            // get.scene = scene->id()
//
// Errors   the server's, with reason and field in error::DetailsOf; kUnavailable without a server
// Threads  any number may call
#ifndef LATTICED_CLIENT_CPP_LIBRARY_LATTICED_CLIENT_H_
#define LATTICED_CLIENT_CPP_LIBRARY_LATTICED_CLIENT_H_

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "client/cpp/library/retries/attentive_channel.h"
#include "client/cpp/library/retries/reachability.h"
#include "client/cpp/library/stream.h"
#include "client/cpp/library/surface.h"
#include "client/cpp/library/watch.h"
#include "core/base/vec.h"
#include "core/patches/patch_plan.h"
#include "grpcpp/channel.h"
#include "latticed/v1/backup.grpc.pb.h"
#include "latticed/v1/mesh.grpc.pb.h"
#include "latticed/v1/points.grpc.pb.h"
#include "latticed/v1/scene.grpc.pb.h"
#include "latticed/v1/server.grpc.pb.h"
#include "latticed/v1/share.grpc.pb.h"

namespace latticed::client {

struct Connection {
  // host:port, or unix:path. Or ip:port of several servers that share a store, joined by commas: calls take them in
  // turn, and reach the server that has the scene by being made again.
  std::string address;
  std::string token;         // bearer token; empty: none is sent
  bool tls = false;          // implied by tls_ca_pem and tls_cert_pem
  std::string tls_ca_pem;    // roots to trust; empty: the system's
  std::string tls_cert_pem;  // client certificate and key, if the server asks for them
  std::string tls_key_pem;
  bool alone = false;  // its own connection, not shared with other clients of this process
  // How long a call or stream tries to reach a server that does not answer; 0: it tries once.
  absl::Duration retry_for = kRetryFor;
  ReachabilityObserver
      observer;  // is told when the client begins to wait, and when the server is back
};

// Called with the work done so far and in all: bytes, or for GetUpdate thousandths of the update.
using Progress = std::function<void(uint64_t done, uint64_t total)>;

// A random scene id: 128 bits as hexadecimal digits.
[[nodiscard]] std::string RandomSceneId();
// A random editor id: a UUID of version 4.
[[nodiscard]] std::string RandomEditorId();

class Client {
 public:
  // Does not wait for the server: without one, the first call waits, and fails. A request of `stop`
  // cancels all calls and streams, present and later ones. It does not cancel deletions, an attempt of
  // CreateScene that has begun, or the last part of an upload, because the caller must know what exists
  // on the server.
  [[nodiscard]] static std::unique_ptr<Client> Connect(const Connection& connection,
                                                       std::stop_token stop = {});
  // Without a channel of their own, streams share the first.
  Client(std::shared_ptr<grpc::Channel> channel, std::string token, std::stop_token stop = {},
         absl::Duration retry_for = kRetryFor, ReachabilityObserver observer = {},
         const std::shared_ptr<grpc::Channel>& stream_channel = nullptr);

  // `probe_bytes`: of ServerInfo.probe, to measure the line.
  [[nodiscard]] absl::StatusOr<v1::ServerInfo> GetServerInfo(uint32_t probe_bytes = 0);
  // Asks gRPC's standard health service, without a token. kUnavailable unless the server is serving.
  [[nodiscard]] absl::Status CheckHealth();

  // Fills in total_bytes and sha256 of the header. Sends nothing if the server has the same bytes in
  // the same format. RAW is always sent, because only the server can compare layouts.
  [[nodiscard]] absl::StatusOr<v1::Mesh> UploadMesh(std::string_view bytes, v1::MeshHeader header,
                                                    const Progress& progress = {});
  [[nodiscard]] absl::StatusOr<v1::Mesh> GetMesh(const std::string& mesh);
  [[nodiscard]] absl::StatusOr<std::vector<v1::Mesh>> ListMeshes(const std::string& filter = "");
  [[nodiscard]] absl::Status DeleteMesh(const std::string& mesh, bool force);

  // An empty scene_id becomes a random one.
  [[nodiscard]] absl::StatusOr<v1::Scene> CreateScene(v1::CreateSceneRequest request);
  [[nodiscard]] absl::StatusOr<v1::Scene> GetScene(const std::string& scene);
  [[nodiscard]] absl::StatusOr<std::vector<v1::Scene>> ListScenes(const std::string& filter = "");
  [[nodiscard]] absl::Status DeleteScene(const std::string& scene);
  // Of several lattices, that with this number, from 0.
  [[nodiscard]] absl::StatusOr<v1::LatticeState> GetLattice(const std::string& scene,
                                                            uint32_t lattice = 0);
  // Only one call per editor of a scene may run at a time. A batch that arrives after one with a higher
  // sequence of the same editor is refused with OUT_OF_ORDER.
  [[nodiscard]] absl::StatusOr<v1::EditResult> ApplyEdits(const v1::EditBatch& batch);
  [[nodiscard]] absl::StatusOr<v1::EvaluatePointsResponse> EvaluatePoints(
      const v1::EvaluatePointsRequest& request);

  // Where the newest revision folds (fold.proto).
  [[nodiscard]] absl::StatusOr<v1::FoldReport> CertifyFolds(const v1::CertifyFoldsRequest& request);

  // The first point of the surface on a ray; kNotFound, reason NOTHING_HIT, if the ray misses it.
  [[nodiscard]] absl::StatusOr<v1::SurfacePoint> Pick(const v1::PickRequest& request);

  // Measures of the exact deformed surface. kFailedPrecondition, reason OPEN_SURFACE, for the volume of an open one.
  [[nodiscard]] absl::StatusOr<v1::MeasureSceneResponse> MeasureScene(
      const v1::MeasureSceneRequest& request);

  // One complete update.
  [[nodiscard]] absl::StatusOr<Surface> GetUpdate(const v1::GetUpdateRequest& request,
                                                  const Progress& progress = {});
  // Returns all parts merged into one.
  [[nodiscard]] absl::StatusOr<v1::TopologyPart> GetTopology(const std::string& scene,
                                                             const std::string& topology_id);
  // What PatchEvaluator needs besides the lattice, once per topology_id of a view with ENCODING_PATCHES. `normals`: those
  // of the view. kDataLoss for a plan that contradicts itself.
  [[nodiscard]] absl::StatusOr<std::shared_ptr<const PatchPlan>> GetPatchPlan(
      const std::string& scene, const std::string& topology_id,
      v1::NormalMode normals = v1::NORMAL_MODE_UNSPECIFIED);
  struct ExportedFile {
    v1::ExportHeader header;
    std::string bytes;
  };
  [[nodiscard]] absl::StatusOr<ExportedFile> Export(const v1::ExportRequest& request,
                                                    const Progress& progress = {});

  [[nodiscard]] absl::StatusOr<v1::CreateShareResponse> CreateShare(
      const v1::CreateShareRequest& request);
  [[nodiscard]] absl::StatusOr<std::vector<v1::Share>> ListShares(const std::string& scene);
  [[nodiscard]] absl::Status RevokeShare(const std::string& scene, const std::string& share);

  // Keeps points beside a scene: `data` are the numbers that the header announces (points.proto). It is tried once: a
  // second attempt could leave the set of the first behind.
  [[nodiscard]] absl::StatusOr<v1::PointSet> CreatePointSet(const v1::PointSetHeader& header,
                                                            std::span<const double> data);
  [[nodiscard]] absl::StatusOr<std::vector<v1::PointSet>> ListPointSets(const std::string& scene);
  [[nodiscard]] absl::Status DeletePointSet(const std::string& scene, const std::string& point_set);
  struct PointVectors {
    v1::PointSetDataHeader header;
    // For each direction: one per point, then with header.with_normals one per normal.
    std::vector<Vec3d> vectors;
  };
  [[nodiscard]] absl::StatusOr<PointVectors> DeformPointSet(
      const v1::DeformPointSetRequest& request);
  [[nodiscard]] absl::StatusOr<PointVectors> ApplyJacobian(const v1::ApplyJacobianRequest& request);
  struct Gradients {
    uint64_t revision = 0, structure_id = 0;
    std::vector<Vec3d> vectors;  // for each direction, one per control point
  };
  // `cotangents`: for each direction of the header, as PointVectors.vectors.
  [[nodiscard]] absl::StatusOr<Gradients> ApplyJacobianTranspose(const v1::CotangentHeader& header,
                                                                 std::span<const Vec3d> cotangents);

  // Streams a backup: `begin` is called first, and again where a broken connection makes the backup begin anew; then `take`
  // with each part. An error of theirs ends it.
  [[nodiscard]] absl::Status Backup(const v1::BackupRequest& request,
                                    const std::function<absl::Status()>& begin,
                                    const std::function<absl::Status(const v1::BackupPart&)>& take);
  // Sends the parts that `next` gives, up to nullopt. It is tried once, when the server answers: after an error, items are
  // there that came before.
  [[nodiscard]] absl::StatusOr<v1::RestoreResponse> Restore(
      const v1::RestoreOptions& options,
      const std::function<absl::StatusOr<std::optional<v1::BackupPart>>()>& next);

  // Opens a stream of updates: see WatchStream.
  [[nodiscard]] absl::StatusOr<std::unique_ptr<WatchStream>> Watch(v1::WatchRequest watch,
                                                                   EventObserver observer = {});
  // Opens a stream of edits and updates: see DeformStream.
  [[nodiscard]] absl::StatusOr<std::unique_ptr<DeformStream>> Deform(v1::WatchRequest watch,
                                                                     EventObserver observer = {});

 private:
  friend class DeformStream;
  friend class WatchStream;
  template <typename Stub, typename Request, typename Response>
  using Method = grpc::Status (Stub::*)(grpc::ClientContext*, const Request&, Response*);
  template <typename Stub, typename Request, typename Message>
  using StreamMethod = std::unique_ptr<grpc::ClientReader<Message>> (Stub::*)(grpc::ClientContext*,
                                                                              const Request&);

  // Makes a context with the token, and with the routing key unless `scene` is empty.
  std::unique_ptr<grpc::ClientContext> NewContext(const std::string& scene = "") const;
  // Makes a unary call about `scene`. A request of `stop` cancels it.
  template <typename Stub, typename Request, typename Response>
  absl::StatusOr<Response> CallOnce(Stub& stub, Method<Stub, Request, Response> method,
                                    const Request& request, const std::string& scene,
                                    const std::stop_token& stop);
  // Like CallOnce, but WithRetries, which stop_ ends.
  template <typename Stub, typename Request, typename Response>
  absl::StatusOr<Response> Call(Stub& stub, Method<Stub, Request, Response> method,
                                const Request& request, const std::string& scene,
                                const std::stop_token& stop);
  // Reads all messages of a call about request.scene(), with attempts like Call. Each attempt begins
  // with `begin`; an error of `take` ends the attempt.
  template <typename Request, typename Message>
  absl::Status Receive(StreamMethod<v1::SceneService::Stub, Request, Message> method,
                       const Request& request, const std::function<void()>& begin,
                       const std::function<absl::Status(Message&&)>& take);

  // Sends a header, then bytes in parts, and gets one message: one attempt.
  template <typename Request, typename Header, typename Response>
  absl::Status SendPoints(std::unique_ptr<grpc::ClientWriter<Request>> (
                              v1::PointSetService::Stub::*method)(grpc::ClientContext*, Response*),
                          const Header& header, std::string_view bytes, Response& response);
  template <typename Request>
  absl::StatusOr<PointVectors> ReceivePoints(
      StreamMethod<v1::PointSetService::Stub, Request, v1::PointSetData> method,
      const Request& request);
  // Called before a stream is opened.
  void WatchStreamSockets();

  const std::shared_ptr<grpc::Channel> channel_, stream_channel_;
  std::string token_;
  std::stop_token stop_;
  const std::unique_ptr<Reachability> reachability_;
  std::unique_ptr<v1::ServerService::Stub> server_;
  std::unique_ptr<v1::MeshService::Stub> meshes_;
  std::unique_ptr<v1::SceneService::Stub> scenes_, streams_;
  std::unique_ptr<v1::BackupService::Stub> backups_;
  std::unique_ptr<v1::ShareService::Stub> shares_;
  std::unique_ptr<v1::PointSetService::Stub> points_;
  std::once_flag has_streams_;
  std::optional<SocketWatch> stream_sockets_;
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LIBRARY_LATTICED_CLIENT_H_
