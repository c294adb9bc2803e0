// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// BackupService.Restore: options, parts, half-close, answer.
//
//   kOptions --options--> kParts --half-close--> done
//                          ^   |  an item is whole: it is made on a worker, and nothing is read meanwhile
//                          +---+
//   Options that do not come within --first-message-timeout end the call. Any refusal or cancellation ends it at once and
//   drops what came of the item under way.
#ifndef LATTICED_SERVER_RPC_BACKUP_RESTORE_STREAM_H_
#define LATTICED_SERVER_RPC_BACKUP_RESTORE_STREAM_H_

#include <grpcpp/grpcpp.h>

namespace latticed {

struct Rpc;
struct ServerEnv;

// The reactor of one call; it deletes itself when the call is done. `env` outlives the server.
[[nodiscard]] grpc::ServerReadReactor<grpc::ByteBuffer>* NewRestoreStream(
    const Rpc& rpc, ServerEnv* env, grpc::CallbackServerContext* context, grpc::ByteBuffer* reply);

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_BACKUP_RESTORE_STREAM_H_
