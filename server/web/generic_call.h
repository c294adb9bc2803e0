// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// An rpc of any method, by its bytes: what gRPC-Web, the WebSocket and downloads are a front for.
//
//   call = GenericCall::Start(channel, {method, metadata, deadline}, post, observer);
//   call->Write(message);   next after OnWritten        call->Read();   next after OnMessage
//
// So nothing queues here: at most one message waits in each direction, and one that is not asked for
// stays with the server, which stops making more.
//
// Threads  methods safe from any thread; the observer is called through `post`
#ifndef LATTICED_SERVER_WEB_GENERIC_CALL_H_
#define LATTICED_SERVER_WEB_GENERIC_CALL_H_

#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/status.h>

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/time/time.h"

namespace grpc {
class Channel;
}

namespace latticed::web {

// Where calls go, and the metadata key under which they say for whom they are made: a secret of this
// process.
struct ServerChannel {
  std::shared_ptr<grpc::Channel> channel;
  std::string peer_key;
};

using CallMetadata = std::vector<std::pair<std::string, std::string>>;  // -bin values not encoded

// What a call says; the last word is OnEnd.
class CallObserver {
 public:
  virtual ~CallObserver() = default;
  // The server's initial metadata; left out where a call ends without.
  virtual void OnHead(CallMetadata metadata) = 0;
  virtual void OnMessage(grpc::ByteBuffer message) = 0;
  virtual void OnWritten() = 0;
  virtual void OnEnd(grpc::Status status, CallMetadata trailers) = 0;
};

class GenericCall {
 public:
  struct Request {
    std::string method;  // "/latticed.v1.SceneService/Deform"
    CallMetadata metadata;
    std::string peer;  // the client's address: HttpRequest::peer
    absl::Time deadline = absl::InfiniteFuture();
  };
  using Post = std::function<void(std::function<void()>)>;

  [[nodiscard]] static std::shared_ptr<GenericCall> Start(const ServerChannel& server,
                                                          const Request& request, Post post,
                                                          std::shared_ptr<CallObserver> observer);
  virtual ~GenericCall() = default;

  // Not before OnWritten of the one before.
  virtual void Write(const grpc::ByteBuffer& message) = 0;
  virtual void WritesDone() = 0;
  // Not before OnMessage of the one before.
  virtual void Read() = 0;
  // OnEnd follows soon.
  virtual void Cancel() = 0;
};

}  // namespace latticed::web

#endif  // LATTICED_SERVER_WEB_GENERIC_CALL_H_
