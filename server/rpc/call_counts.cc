// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/call_counts.h"

#include "fmt/format.h"
#include "google/protobuf/descriptor.h"
#include "latticed/v1/backup.pb.h"
#include "latticed/v1/mesh.pb.h"
#include "latticed/v1/points.pb.h"
#include "latticed/v1/scene.pb.h"
#include "latticed/v1/server.pb.h"
#include "latticed/v1/share.pb.h"

namespace latticed {

CallCounts::CallCounts() {
  for (const auto* message :
       {v1::Mesh::descriptor(), v1::Scene::descriptor(), v1::ServerInfo::descriptor(),
        v1::BackupPart::descriptor(), v1::Share::descriptor(), v1::PointSet::descriptor()}) {
    const auto* service = message->file()->service(0);
    for (int m = 0; m < service->method_count(); ++m) {
      rpcs_[fmt::format("{}/{}", service->name(), service->method(m)->name())];
    }
  }
}

}  // namespace latticed
