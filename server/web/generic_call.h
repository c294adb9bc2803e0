// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// An rpc of any method, by its bytes. gRPC-Web, the WebSocket and downloads make their calls by it.
//
//   call = GenericCall::Start(channel, {method, metadata, peer, deadline}, exchange, observer);
//   call->Write(message);   next after OnWritten        call->Read();   next after OnMessage
//
// At most one message waits in each direction. A message that is not asked for stays with the server,
// which then makes no more.
//
// Threads  methods safe from any thread; the observer is called on the strand of its carrier
#ifndef LATTICED_SERVER_WEB_GENERIC_CALL_H_
#define LATTICED_SERVER_WEB_GENERIC_CALL_H_

#include <grpcpp/client_context.h>
#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/client_callback.h>
#include <grpcpp/support/status.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/time/time.h"
#include "core/base/mutex.h"

namespace grpc {
class Channel;
}

namespace latticed::web {

// Where calls go, and the metadata key that carries the client's address. The key is a secret of this
// process.
struct ServerChannel {
  std::shared_ptr<grpc::Channel> channel;
  std::string peer_key;
};

using CallMetadata = std::vector<std::pair<std::string, std::string>>;  // -bin values not encoded

// Hears of one call. OnEnd comes last.
class CallObserver {
 public:
  virtual ~CallObserver() = default;
  // The server's initial metadata. Not called where a call ends without any.
  virtual void OnHead(CallMetadata metadata) = 0;
  virtual void OnMessage(grpc::ByteBuffer message) = 0;
  virtual void OnWritten() = 0;
  virtual void OnEnd(grpc::Status status, CallMetadata trailers) = 0;
};

class GenericCall final : private grpc::ClientBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>,
                          public std::enable_shared_from_this<GenericCall> {
 public:
  struct Request {
    std::string method;  // "/latticed.v1.SceneService/Deform"
    CallMetadata metadata;
    std::string peer;  // the client's address: HttpRequest::peer
    absl::Time deadline = absl::InfiniteFuture();
  };
  using Post = std::function<void(std::function<void()>)>;

  // Calls the observer on the strand of `carrier`, an HttpExchange or a WebSocket, and cancels the
  // call when that has gone.
  template <typename Carrier>
  [[nodiscard]] static std::shared_ptr<GenericCall> Start(const ServerChannel& server,
                                                          const Request& request,
                                                          const std::shared_ptr<Carrier>& carrier,
                                                          std::shared_ptr<CallObserver> observer) {
    const auto call = std::make_shared<GenericCall>(
        [carrier](std::function<void()> work) { carrier->Post(std::move(work)); },
        std::move(observer));
    carrier->OnGone([call] { call->Cancel(); });
    call->Begin(server, request);
    return call;
  }
  GenericCall(Post post, std::shared_ptr<CallObserver> observer)
      : post_(std::move(post)), observer_(std::move(observer)) {}

  // Not before OnWritten of the one before.
  void Write(const std::string& message) ABSL_LOCKS_EXCLUDED(mutex_);
  void WritesDone() ABSL_LOCKS_EXCLUDED(mutex_);
  // Not before OnMessage of the one before.
  void Read() ABSL_LOCKS_EXCLUDED(mutex_);
  // OnEnd follows soon.
  void Cancel();

 private:
  void Begin(const ServerChannel& server, const Request& request);
  void OnReadInitialMetadataDone(bool ok) override;
  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnDone(const grpc::Status& status) override;
  void Hand(const grpc::ByteBuffer& message);
  // Starts no more operations, so that OnDone can come.
  void Release() ABSL_LOCKS_EXCLUDED(mutex_);

  const Post post_;
  std::shared_ptr<CallObserver> observer_;  // until OnDone
  std::shared_ptr<GenericCall> self_;       // gRPC's reference, until OnDone
  grpc::ClientContext context_;
  grpc::ByteBuffer reading_, writing_;
  Mutex mutex_;
  bool released_ ABSL_GUARDED_BY(mutex_) = false;
  bool head_read_ ABSL_GUARDED_BY(mutex_) = false;
  std::optional<grpc::ByteBuffer> early_ ABSL_GUARDED_BY(mutex_);  // read before the head
};

}  // namespace latticed::web

#endif  // LATTICED_SERVER_WEB_GENERIC_CALL_H_
