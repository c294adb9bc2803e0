// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Clients of Watch and Deform through the stub. They read when told to, and cancel when destroyed.
#ifndef LATTICED_TESTS_SERVER_SUPPORT_STREAM_CLIENTS_H_
#define LATTICED_TESTS_SERVER_SUPPORT_STREAM_CLIENTS_H_

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include "absl/status/status.h"
#include "client/cpp/library/status.h"
#include "latticed/v1/scene.grpc.pb.h"

namespace latticed::testing {

using Metadata = std::map<std::string, std::string>;

// A stream that is open for longer fails its test.
inline constexpr std::chrono::minutes kStreamDeadline{2};

// Applies events as a client does, and fails the test when a guarantee is broken.
class EventLog {
 public:
  void Take(const v1::SceneEvent& event);

  std::vector<v1::SceneEvent> events;
  v1::Hello hello;
  v1::LatticeState lattice;  // lattice 0, with the deltas applied; its revision is that of all
  std::map<uint32_t, v1::LatticeState> others;
  v1::LatticeState sum;  // of several, as of the last patch_lattice
  std::vector<v1::Topology> topologies;
  std::vector<v1::Quantisation> quantisations;
  std::vector<v1::UpdateBegin> begins;
  std::vector<v1::UpdateEnd> ends;
  std::vector<v1::EditResult> results;
  std::vector<v1::Presence> presences;
  std::vector<v1::Goaway> goaways;
  size_t heartbeats = 0;
  size_t deltas = 0;
  std::map<uint32_t, std::string> chunks;  // as of the last update_end; of bounds, empty
  std::vector<uint8_t> bounds;             // by edge, of the last topology; of views of patches
  std::map<uint32_t, std::string> levels;  // the same; of views with a tolerance
  std::map<uint32_t, v1::PatchPattern> patterns;  // by code

 private:
  void TakeSum(const v1::PatchLattice& news);
  void TakePatterns(const v1::SceneEvent& event);
  void TakeChunk(const v1::Chunk& chunk);
  void TakeBounds(const v1::Chunk& chunk);

  bool in_update_ = false;
  uint32_t last_moved_ = 0;  // the lattice of the last delta
  std::map<uint32_t, v1::Chunk> staged_;
  std::vector<v1::Chunk> staged_bounds_;
};

template <class Stream>
class EventStream {
 public:
  EventStream(const EventStream&) = delete;  // the call points to context_
  EventStream& operator=(const EventStream&) = delete;

  // Reads one event into log; false at the end.
  bool Read() {
    v1::SceneEvent event;
    if (status_.has_value() || !stream_->Read(&event)) return false;
    log.Take(event);
    return true;
  }
  // Reads until `done`. Fails the test when the stream ends first.
  void ReadUntil(const std::function<bool()>& done) {
    while (!done()) ASSERT_TRUE(Read()) << "the stream ended: " << Finish();
  }
  void ReadUntilRevision(uint64_t revision) {
    ReadUntil([&] { return !log.ends.empty() && log.ends.back().revision() >= revision; });
  }
  void ReadUpdates(size_t count) {
    ReadUntil([&] { return log.ends.size() >= count; });
  }
  void Cancel() { context_.TryCancel(); }
  // Of the headers that have come. Empty if there is none of that name.
  std::string InitialMetadata(const std::string& name) const {
    const auto& metadata = context_.GetServerInitialMetadata();
    const auto found = metadata.find(name);
    return found == metadata.end() ? "" : std::string(found->second.data(), found->second.size());
  }
  // Reads to the end and returns the status.
  absl::Status Finish() {
    if (!status_.has_value()) {
      while (Read()) continue;
      status_ = client::FromGrpc(stream_->Finish());
    }
    return *status_;
  }

  EventLog log;

 protected:
  explicit EventStream(const Metadata& metadata) {
    context_.set_deadline(std::chrono::system_clock::now() + kStreamDeadline);
    for (const auto& [name, value] : metadata) context_.AddMetadata(name, value);
  }
  ~EventStream() {
    Cancel();
    (void)Finish();
  }

  grpc::ClientContext context_;
  std::unique_ptr<Stream> stream_;

 private:
  std::optional<absl::Status> status_;  // once finished
};

class WatchClient : public EventStream<grpc::ClientReader<v1::SceneEvent>> {
 public:
  WatchClient(v1::SceneService::Stub& stub, const v1::WatchRequest& request,
              const Metadata& metadata = {})
      : EventStream(metadata) {
    stream_ = stub.Watch(&context_, request);
  }
};

class DeformClient
    : public EventStream<grpc::ClientReaderWriter<v1::DeformRequest, v1::SceneEvent>> {
 public:
  explicit DeformClient(v1::SceneService::Stub& stub) : DeformClient(stub, nullptr, {}) {}
  // Opens the stream with `request`.
  DeformClient(v1::SceneService::Stub& stub, const v1::WatchRequest& request,
               const Metadata& metadata = {})
      : DeformClient(stub, &request, metadata) {}

  bool Open(const v1::WatchRequest& request) {
    v1::DeformRequest message;
    *message.mutable_watch() = request;
    return Send(message);
  }
  bool Send(const v1::EditBatch& batch) {
    v1::DeformRequest message;
    *message.mutable_edit() = batch;
    return Send(message);
  }
  bool Send(const v1::DeformRequest& request) { return stream_->Write(request); }
  bool Ack(uint64_t update_id) {
    v1::DeformRequest message;
    message.mutable_control()->set_acked_update_id(update_id);
    return Send(message);
  }
  bool SetPaused(bool paused) {
    v1::DeformRequest message;
    message.mutable_control()->set_pause(paused);
    return Send(message);
  }
  void HalfClose() { stream_->WritesDone(); }

 private:
  DeformClient(v1::SceneService::Stub& stub, const v1::WatchRequest* request,
               const Metadata& metadata)
      : EventStream(metadata) {
    stream_ = stub.Deform(&context_);
    if (request == nullptr) return;
    EXPECT_TRUE(Open(*request));
  }
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_SUPPORT_STREAM_CLIENTS_H_
