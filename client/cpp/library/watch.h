// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A watch without edits, for which a read token suffices: it acknowledges updates and answers
// heartbeats by ControlWatch, and opens itself again as ResumingStream does.
//
//   auto watch = client->Watch(request);
//   for (auto update = (*watch)->first_update(); update.has_value(); …) {
//     …                                           // (*watch)->surface() shows the update
//     auto next = (*watch)->Next();
//
// Errors   the server's, after five attempts in a row to open it again; kDataLoss as Surface
// Threads  one at a time; Cancel from any
#ifndef LATTICED_CLIENT_CPP_LIBRARY_WATCH_H_
#define LATTICED_CLIENT_CPP_LIBRARY_WATCH_H_

#include <memory>
#include <optional>

#include "absl/status/statusor.h"
#include "client/cpp/library/presence.h"
#include "client/cpp/library/resuming.h"
#include "client/cpp/library/surface.h"
#include "grpcpp/support/sync_stream.h"
#include "latticed/v1/scene.grpc.pb.h"

namespace latticed::client {

class Client;

class WatchStream {
 public:
  WatchStream(const WatchStream&) = delete;
  WatchStream& operator=(const WatchStream&) = delete;

  // Waits for the next complete update; nullopt when the watch was cancelled or has ended OK.
  [[nodiscard]] absl::StatusOr<std::optional<CompleteUpdate>> Next();
  // Changes the view, pauses or resumes; scene and watch_id are filled in.
  [[nodiscard]] absl::Status Control(v1::ControlWatchRequest request);
  // Shows others who this watch's editor is, which it must name, until the watch ends; role edit.
  [[nodiscard]] absl::Status Show(v1::Presence presence);
  // Who else is there, as far as Next has read.
  const Others& others() const { return presence_.others(); }
  void Cancel() { stream_.Cancel(); }

  // What the watch opened with.
  const std::optional<CompleteUpdate>& first_update() const { return first_update_; }
  const Surface& surface() const { return surface_; }
  const v1::Hello& hello() const { return hello_; }
  // How often it had to open itself again.
  int reconnections() const { return stream_.reconnections(); }

 private:
  friend class Client;

  static absl::StatusOr<std::unique_ptr<WatchStream>> Open(Client* client, v1::WatchRequest watch,
                                                           EventObserver observer);
  WatchStream(Client* client, v1::WatchRequest watch, EventObserver observer);

  absl::StatusOr<std::optional<CompleteUpdate>> Take(v1::SceneEvent event);
  absl::Status ControlPresence(const v1::Presence& presence);

  Client* const client_;
  Surface surface_;
  std::optional<CompleteUpdate> first_update_;
  v1::Hello hello_;
  PresenceState presence_;
  ResumingStream<grpc::ClientReader<v1::SceneEvent>> stream_;
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LIBRARY_WATCH_H_
