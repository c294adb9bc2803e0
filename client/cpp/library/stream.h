// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A Deform stream that lives as long as its user wants. It acknowledges updates, answers
// heartbeats, and opens itself again like every ResumingStream. It then sends unanswered edits
// again; by their sequences the server applies each once.
//
//   stream->Send(batch);                          // returns at once; fills in the sequence
//   auto step = stream->Next();                   // waits for the next result or update
//   auto update = stream->WaitFor(sequence);      // waits for an update that holds the edit
//
// Errors   those of ResumingStream; kDataLoss as Surface
// Threads  one at a time; Cancel from any
#ifndef LATTICED_CLIENT_CPP_LIBRARY_STREAM_H_
#define LATTICED_CLIENT_CPP_LIBRARY_STREAM_H_

#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "client/cpp/library/resuming.h"
#include "client/cpp/library/surface.h"
#include "grpcpp/support/sync_stream.h"
#include "latticed/v1/scene.grpc.pb.h"

namespace latticed::client {

class Client;

class DeformStream final
    : public ResumingStream<grpc::ClientReaderWriter<v1::DeformRequest, v1::SceneEvent>> {
 public:
  // The result of Next. Both are empty when the stream has ended OK or was cancelled.
  struct Step {
    std::optional<CompleteUpdate> update;
    std::optional<v1::EditResult> result;
    bool ended() const { return !update.has_value() && !result.has_value(); }
  };

  // Sends edits; returns their sequence. A structure_id of 0 becomes the lattice's newest.
  // kInvalidArgument for an editor that is not the stream's; kFailedPrecondition after HalfClose or
  // the stream's end.
  [[nodiscard]] absl::StatusOr<uint64_t> Send(v1::EditBatch batch);
  // Waits for the next edit result or complete update.
  [[nodiscard]] absl::StatusOr<Step> Next();
  // Waits for an update that holds the edit, and returns the newest update. May be called for edits in
  // any order. For a refused edit returns the refusal; the stream keeps the 1,024 newest refusals.
  // kInvalidArgument for a sequence that was never sent.
  [[nodiscard]] absl::StatusOr<CompleteUpdate> WaitFor(uint64_t sequence);
  // Shows others who this editor is, what it has selected and its camera, until the stream ends. Fills in
  // editor_id. If the server refuses, it ends the stream. kFailedPrecondition as for Send.
  [[nodiscard]] absl::Status Show(v1::Presence presence);
  // No more edits: the stream ends after the update that holds the last one.
  void HalfClose();
  const std::string& editor_id() const { return watch().editor_id(); }

 private:
  friend class Client;
  using Rpc = grpc::ClientReaderWriter<v1::DeformRequest, v1::SceneEvent>;

  static absl::StatusOr<std::unique_ptr<DeformStream>> Open(Client* client, v1::WatchRequest watch,
                                                            EventObserver observer);
  DeformStream(Client* client, v1::WatchRequest watch, EventObserver observer);

  std::unique_ptr<grpc::ClientContext> NewContext() override;
  // Sends the watch, the presence and the unanswered edits.
  std::unique_ptr<Rpc> OpenRpc(grpc::ClientContext* context) override;
  void EndRequests() override;
  // Writes the request if the rpc takes more.
  void Write(const v1::DeformRequest& request);
  absl::StatusOr<Step> Take(v1::SceneEvent event);
  static bool IsForNextServer(const v1::EditResult& result);
  bool IsLostAnswer(const v1::EditResult& result) const;
  void Answer(const v1::EditResult& result);
  void Remember(const CompleteUpdate& update);

  Client* const client_;
  std::deque<v1::EditBatch> unanswered_;
  std::map<uint64_t, absl::Status> refusals_;
  std::optional<CompleteUpdate> newest_update_;
  uint64_t last_sequence_ = 0;
  uint64_t resent_ = 0;  // the last sequence that was sent again
  bool half_closed_ = false;
  bool rpc_half_closed_ = false;  // also after a goaway
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LIBRARY_STREAM_H_
