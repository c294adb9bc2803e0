// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A call of any rpc, with messages as bytes. gRPC-Web, the WebSocket and downloads use it.
//
//   call = GenericCall::Start(channel, {method, metadata, peer, deadline}, observer);
//   call->Write(message);   next after OnWritten        call->Read();   next after OnMessage
//
// At most one message waits in each direction. A message that nobody asks for stays with the server, which
// then makes no more.
//
// Threads  methods safe from any thread; the observer is called on its strand
#ifndef LATTICED_SERVER_WEB_GENERIC_CALL_H_
#define LATTICED_SERVER_WEB_GENERIC_CALL_H_

#include <grpcpp/client_context.h>
#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/client_callback.h>
#include <grpcpp/support/slice.h>
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
#include "server/web/http_exchange.h"

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

using CallMetadata = HttpFields;

// Its bytes, shared.
[[nodiscard]] std::vector<grpc::Slice> SlicesOf(const grpc::ByteBuffer& message);

// Is told of the events of one call. OnEnd comes last.
class CallObserver {
 public:
  virtual ~CallObserver() = default;
  // Runs `work` on the strand on which all other functions are called. Any thread may call it.
  virtual void Post(std::function<void()> work) = 0;
  // The server's initial metadata. Not called when the call ends without any.
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

  [[nodiscard]] static std::shared_ptr<GenericCall> Start(const ServerChannel& server,
                                                          const Request& request,
                                                          std::shared_ptr<CallObserver> observer);
  explicit GenericCall(std::shared_ptr<CallObserver> observer) : observer_(std::move(observer)) {}

  // Called only after OnWritten of the message before.
  void Write(const std::string& message) ABSL_LOCKS_EXCLUDED(mutex_);
  void WritesDone() ABSL_LOCKS_EXCLUDED(mutex_);
  // Asks for the next message. The first one comes without asking.
  void Read() ABSL_LOCKS_EXCLUDED(mutex_);
  // Cancels the call; OnEnd follows soon.
  void Cancel();

 private:
  void OnReadInitialMetadataDone(bool ok) override;
  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnDone(const grpc::Status& status) override;
  void Hand(const grpc::ByteBuffer& message);
  // Starts no more operations, so that OnDone can come.
  void Release() ABSL_LOCKS_EXCLUDED(mutex_);

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
