// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A watch without edits, for which a token of role read suffices. It acknowledges updates and answers
// heartbeats by ControlWatch, and opens itself again like every ResumingStream.
//
//   auto watch = client->Watch(request);
//   for (auto update = (*watch)->first_update(); update.has_value(); …) {
//     …                                           // (*watch)->surface() holds the update
//     auto next = (*watch)->Next();
//
// Errors   those of ResumingStream; kDataLoss as Surface
// Threads  one at a time; Cancel from any
#ifndef LATTICED_CLIENT_CPP_LIBRARY_WATCH_H_
#define LATTICED_CLIENT_CPP_LIBRARY_WATCH_H_

#include <memory>
#include <optional>

#include "absl/status/statusor.h"
#include "client/cpp/library/resuming.h"
#include "client/cpp/library/surface.h"
#include "grpcpp/support/sync_stream.h"
#include "latticed/v1/scene.grpc.pb.h"

namespace latticed::client {

class Client;

class WatchStream final : public ResumingStream<grpc::ClientReader<v1::SceneEvent>> {
 public:
  // Waits for the next complete update; nullopt when the watch was cancelled or has ended OK.
  [[nodiscard]] absl::StatusOr<std::optional<CompleteUpdate>> Next();
  // Changes the view, pauses or resumes. Fills in scene and watch_id.
  [[nodiscard]] absl::Status Control(v1::ControlWatchRequest request);
  // Shows others who this watch's editor is until the watch ends. The watch must name its editor,
  // and needs the role edit.
  [[nodiscard]] absl::Status Show(v1::Presence presence);

 private:
  friend class Client;
  using Rpc = grpc::ClientReader<v1::SceneEvent>;

  static absl::StatusOr<std::unique_ptr<WatchStream>> Open(Client* client, v1::WatchRequest watch,
                                                           EventObserver observer);
  WatchStream(Client* client, v1::WatchRequest watch, EventObserver observer);

  std::unique_ptr<grpc::ClientContext> NewContext() override;
  std::unique_ptr<Rpc> OpenRpc(grpc::ClientContext* context) override;
  absl::StatusOr<std::optional<CompleteUpdate>> Take(v1::SceneEvent event);
  absl::Status ControlPresence();

  Client* const client_;
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LIBRARY_WATCH_H_
