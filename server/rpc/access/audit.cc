// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/access/audit.h"

#include <string>

#include "absl/time/clock.h"
#include "server/base/auth/tenant.h"
#include "server/rpc/call.h"
#include "server/rpc/server_env.h"

namespace latticed {
namespace {

AuditActor ActorOf(const CallInfo& call) {
  return {.tenant = call.caller.tenant,
          .caller = call.caller.name,
          .peer = call.peer,
          .request_id = call.request_id};
}

}  // namespace

void Audit(ServerEnv& env, const CallInfo& call, const char* event, const AuditFields& fields) {
  if (env.options.audit_log.empty()) return;
  env.audit.Note(event, ActorOf(call), fields, absl::Now());
}

void AuditEdit(ServerEnv& env, const CallInfo& call, std::string_view scene) {
  if (env.options.audit_log.empty()) return;
  env.audit.NoteEdit(ActorOf(call), std::string(IdOf(scene)), absl::Now());
}

}  // namespace latticed
