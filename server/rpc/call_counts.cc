// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/call_counts.h"

#include "fmt/format.h"
#include "google/protobuf/descriptor.h"
#include "latticed/v1/mesh.pb.h"
#include "latticed/v1/scene.pb.h"
#include "latticed/v1/server.pb.h"

namespace latticed {
namespace {

constexpr std::string_view kReasonPrefix = "ERROR_REASON_";

}  // namespace

CallCounts::CallCounts() {
  for (const auto* message :
       {v1::Mesh::descriptor(), v1::Scene::descriptor(), v1::ServerInfo::descriptor()}) {
    const auto* file = message->file();
    for (int s = 0; s < file->service_count(); ++s) {
      const auto* service = file->service(s);
      for (int m = 0; m < service->method_count(); ++m) {
        rpcs_[fmt::format("{}/{}", service->name(), service->method(m)->name())];
      }
    }
  }
}

RpcCounts* CallCounts::Find(std::string_view rpc) {
  const auto found = rpcs_.find(rpc);
  return found == rpcs_.end() ? nullptr : &found->second;
}

void CallCounts::NoteRefusal(std::string_view reason) {
  v1::ErrorReason value = v1::ERROR_REASON_UNSPECIFIED;
  if (!v1::ErrorReason_Parse(fmt::format("{}{}", kReasonPrefix, reason), &value)) return;
  ++refusals_[static_cast<size_t>(value)];
}

std::string CallCounts::NameOf(v1::ErrorReason reason) {
  return v1::ErrorReason_Name(reason).substr(kReasonPrefix.size());
}

}  // namespace latticed
