// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A row of a service's table: the name of an rpc, the role that its callers need, and its handler.
//
//   constexpr UnaryMethod kGetScene{Rpc{"SceneService/GetScene", Role::kRead}, GetScene};
//
//   grpc::ServerUnaryReactor* GetScene(…) override { return kGetScene.Run(env_, context, request, response); }
//
// Threads  Run is gRPC's to call
#ifndef LATTICED_SERVER_RPC_METHOD_H_
#define LATTICED_SERVER_RPC_METHOD_H_

#include <functional>
#include <string>

#include <grpcpp/grpcpp.h>

#include "absl/status/statusor.h"
#include "server/base/auth.h"
#include "server/rpc/part_stream.h"
#include "server/rpc/unary_call.h"

namespace latticed {

// One request, one reply; the handler runs on a worker.
template <typename Request, typename Response>
struct UnaryMethod {
  Rpc rpc;
  absl::Status (*handler)(const UnaryContext&, const Request&, Response&);

  grpc::ServerUnaryReactor* Run(ServerEnv* env, grpc::CallbackServerContext* context,
                                const Request* request, Response* response) const {
    return RunUnary(env, context, rpc, *request, response,
                    [handler = handler, request, response](const UnaryContext& unary) {
                      return handler(unary, *request, *response);
                    });
  }
};

// Clang 14 deduces no aggregates by itself.
template <typename Request, typename Response>
UnaryMethod(Rpc, absl::Status (*)(const UnaryContext&, const Request&, Response&))
    -> UnaryMethod<Request, Response>;

// A server stream of parts; `open` runs on a worker.
template <typename Request, typename Message>
struct PartMethod {
  Rpc rpc;
  absl::StatusOr<NextPart<Message>> (*open)(const PartContext&, const Request&);

  grpc::ServerWriteReactor<Message>* Run(ServerEnv* env, grpc::CallbackServerContext* context,
                                         const Request* request) const {
    std::string scene;
    if constexpr (requires { request->scene(); }) scene = request->scene();
    return new PartStream<Message>(
        env, context, rpc, *request, scene,
        [open = open, env, context, request](const std::function<bool()>& cancelled) {
          return open({*env, *context, cancelled}, *request);
        });
  }
};

template <typename Request, typename Message>
PartMethod(Rpc, absl::StatusOr<NextPart<Message>> (*)(const PartContext&, const Request&))
    -> PartMethod<Request, Message>;

// A stream with a reactor of its own, which deletes itself when the call is done.
template <typename Reactor, typename... Messages>
struct StreamMethod {
  Rpc rpc;
  Reactor* (*open)(const Rpc&, ServerEnv*, grpc::CallbackServerContext*, Messages...);

  Reactor* Run(ServerEnv* env, grpc::CallbackServerContext* context, Messages... messages) const {
    return open(rpc, env, context, messages...);
  }
};

template <typename Reactor, typename... Messages>
StreamMethod(Rpc, Reactor* (*)(const Rpc&, ServerEnv*, grpc::CallbackServerContext*, Messages...))
    -> StreamMethod<Reactor, Messages...>;

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_METHOD_H_
