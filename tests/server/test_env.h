// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A server in this process on a free port, and real stubs to it: tests know no server internals.
#ifndef LATTICED_TESTS_SERVER_TEST_ENV_H_
#define LATTICED_TESTS_SERVER_TEST_ENV_H_

#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <string_view>

#include "core/base/error.h"
#include "latticed/v1/mesh.grpc.pb.h"
#include "latticed/v1/scene.grpc.pb.h"
#include "latticed/v1/server.grpc.pb.h"
#include "server/in_process.h"

namespace latticed::testing {

// Small, quiet, CPU.
[[nodiscard]] Options TestOptions();

// Cubes: 8 vertices, 6 quads. Another edge length, another mesh id.
[[nodiscard]] std::string CubeObj(double edge = 1);

[[nodiscard]] v1::MeshHeader ObjHeader(const std::string& bytes);

// The published reason of a failed call, such as "NOT_FOUND".
[[nodiscard]] std::string Reason(const grpc::Status& status);

class TestEnv {
 public:
  // Fails the test where the server does not start.
  explicit TestEnv(Options options = TestOptions());

  InProcessServer& server() { return *server_; }
  v1::MeshService::Stub& meshes() { return *meshes_; }
  v1::SceneService::Stub& scenes() { return *scenes_; }
  v1::ServerService::Stub& info() { return *info_; }
  const std::shared_ptr<grpc::Channel>& channel() { return channel_; }

  // Header and bytes in parts of 64 KiB.
  grpc::Status Upload(const v1::MeshHeader& header, std::string_view bytes, v1::Mesh* mesh);
  // A cube; fails the test where it is refused.
  v1::Mesh UploadCube(double edge = 1);

 private:
  std::unique_ptr<InProcessServer> server_;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<v1::MeshService::Stub> meshes_;
  std::unique_ptr<v1::SceneService::Stub> scenes_;
  std::unique_ptr<v1::ServerService::Stub> info_;
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_TEST_ENV_H_
