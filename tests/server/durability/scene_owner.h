// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#ifndef LATTICED_TESTS_SERVER_DURABILITY_SCENE_OWNER_H_
#define LATTICED_TESTS_SERVER_DURABILITY_SCENE_OWNER_H_

#include <chrono>
#include <string>
#include <utility>

#include "tests/server/support/server_test.h"

namespace latticed::testing {

// The owner that the reply to GetScene names, and the call's status.
inline std::pair<std::string, absl::Status> SceneOwner(v1::SceneService::Stub& stub,
                                                       v1::Scene* scene) {
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::minutes(1));
  const absl::Status status =
      client::FromGrpc(stub.GetScene(&context, For<v1::GetSceneRequest>(), scene));
  const auto& metadata = context.GetServerInitialMetadata();
  const auto owner = metadata.find("latticed-owner");
  if (owner == metadata.end()) return {"", status};
  return {std::string(owner->second.data(), owner->second.size()), status};
}

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_DURABILITY_SCENE_OWNER_H_
