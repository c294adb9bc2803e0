// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The calls of PointSetService whose client sends points: CreatePointSet and ApplyJacobianTranspose.
//
// Threads  as data_stream.h; `env` outlives the server
#ifndef LATTICED_SERVER_RPC_POINTS_POINT_STREAMS_H_
#define LATTICED_SERVER_RPC_POINTS_POINT_STREAMS_H_

#include <grpcpp/grpcpp.h>

namespace latticed {

struct Rpc;
struct ServerEnv;

[[nodiscard]] grpc::ServerReadReactor<grpc::ByteBuffer>* NewCreatePointSet(
    const Rpc& rpc, ServerEnv* env, grpc::CallbackServerContext* context, grpc::ByteBuffer* reply);
[[nodiscard]] grpc::ServerReadReactor<grpc::ByteBuffer>* NewApplyJacobianTranspose(
    const Rpc& rpc, ServerEnv* env, grpc::CallbackServerContext* context, grpc::ByteBuffer* reply);

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_POINTS_POINT_STREAMS_H_
