// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What handlers note in the audit log, which may be off.
//
// Threads  safe
#ifndef LATTICED_SERVER_RPC_ACCESS_AUDIT_H_
#define LATTICED_SERVER_RPC_ACCESS_AUDIT_H_

#include <string_view>

#include "server/base/audit_log.h"

namespace latticed {

struct CallInfo;   // server/rpc/call.h
struct ServerEnv;  // server/rpc/server_env.h

// The caller has done what `event` says.
void Audit(ServerEnv& env, const CallInfo& call, const char* event, const AuditFields& fields);
// The caller has edited the scene, which is named by its key (server/base/auth/tenant.h).
void AuditEdit(ServerEnv& env, const CallInfo& call, std::string_view scene);

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_ACCESS_AUDIT_H_
