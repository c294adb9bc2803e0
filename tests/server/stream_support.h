// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A server in this process with one mesh and one scene, and clients of its streams through the
// stub.
#ifndef LATTICED_TESTS_SERVER_STREAM_SUPPORT_H_
#define LATTICED_TESTS_SERVER_STREAM_SUPPORT_H_

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include "absl/time/time.h"
#include "latticed/v1/mesh.grpc.pb.h"
#include "latticed/v1/scene.grpc.pb.h"
#include "latticed/v1/server.grpc.pb.h"
#include "server/in_process.h"

namespace latticed::testing {

// A test whose stream is open for longer has failed.
inline constexpr std::chrono::minutes kStreamDeadline{2};

// Applies events as a client does, and fails the test when a guarantee is broken.
class EventLog {
 public:
  void Take(const v1::SceneEvent& event);

  std::vector<v1::SceneEvent> events;
  v1::Hello hello;
  v1::LatticeState lattice;  // deltas applied
  std::vector<v1::Topology> topologies;
  std::vector<v1::Quantisation> quantisations;
  std::vector<v1::UpdateBegin> begins;
  std::vector<v1::UpdateEnd> ends;
  std::vector<v1::EditResult> results;
  std::vector<v1::Presence> presences;
  std::vector<v1::Goaway> goaways;
  size_t heartbeats = 0;
  size_t deltas = 0;
  std::map<uint32_t, std::string> chunks;  // as of the last update_end

 private:
  bool in_update_ = false;
  std::map<uint32_t, std::string> staged_;
};

class StreamTest : public ::testing::Test {
 protected:
  static constexpr char kScene[] = "scene-under-test";

  // Watchers that say nothing are not paused before the deadline.
  static constexpr absl::Duration kHeartbeat = absl::Seconds(60);

  void SetUp() override { StartServer(kHeartbeat); }
  void StartServer(absl::Duration heartbeat);
  // A wavy grid, a lattice of 5^3 control points of degree 2, 4 segments, QUANTISED.
  void CreateScene(int cells = 8);
  v1::WatchRequest Watch(const std::string& editor = "alice") const;
  v1::EditBatch Move(uint64_t sequence, uint32_t index, double dz,
                     const std::string& editor = "alice") const;
  // Through the unary rpc.
  grpc::Status Apply(const v1::EditBatch& batch, v1::EditResult* result = nullptr);
  grpc::Status Update(const v1::GetUpdateRequest& request, EventLog& log);
  v1::ServerInfo Info();
  uint64_t structure_id_ = 1;
  std::string mesh_id_;

  std::unique_ptr<InProcessServer> server_;
  std::unique_ptr<v1::MeshService::Stub> meshes_;
  std::unique_ptr<v1::SceneService::Stub> scenes_;
};

// A Deform stream that reads when it is told to.
class DeformClient {
 public:
  explicit DeformClient(v1::SceneService::Stub& stub);
  ~DeformClient();

  void Open(const v1::WatchRequest& request);
  bool Send(const v1::EditBatch& batch);
  bool Send(const v1::DeformRequest& request) { return stream_->Write(request); }
  bool Ack(uint64_t update_id);
  bool Read();  // one event into log
  // Reads until `done`; fails the test when the stream ends before.
  void ReadUntil(const std::function<bool()>& done);
  void ReadUntilRevision(uint64_t revision);
  void HalfClose() { stream_->WritesDone(); }
  void Cancel() { context_.TryCancel(); }
  // Reads to the end.
  grpc::Status Finish();

  EventLog log;

 private:
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::DeformRequest, v1::SceneEvent>> stream_;
  std::optional<grpc::Status> status_;  // once finished
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_STREAM_SUPPORT_H_
