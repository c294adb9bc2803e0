// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/server/test_env.h"

#include <algorithm>

#include "client/cpp/library/status.h"
#include "fmt/format.h"

namespace latticed::testing {

Options TestOptions() {
  Options options;
  options.backend = "cpu";
  options.threads = 1;
  options.memory_bytes = uint64_t{64} << 20;
  options.max_mesh_bytes = uint64_t{16} << 20;
  options.drain_delay = absl::ZeroDuration();
  options.node = "test-node";
  options.log_level = "off";
  return options;
}

std::string CubeObj(double edge) {
  std::string text;
  for (int i = 0; i < 8; ++i) {
    text += fmt::format("v {} {} {}\n", (i & 1) * edge, ((i >> 1) & 1) * edge, (i >> 2) * edge);
  }
  return text + "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
}

v1::MeshHeader ObjHeader(const std::string& bytes) {
  v1::MeshHeader header;
  header.set_name("cube");
  header.set_format(v1::MESH_FORMAT_OBJ);
  header.set_total_bytes(bytes.size());
  return header;
}

std::string Reason(const grpc::Status& status) {
  return error::DetailsOf(client::FromGrpc(status)).reason;
}

TestEnv::TestEnv(Options options) {
  auto server = InProcessServer::Start(std::move(options));
  if (!server.ok()) {
    ADD_FAILURE() << server.status();
    std::abort();  // no test makes sense without it
  }
  server_ = *std::move(server);
  channel_ = server_->channel();
  meshes_ = v1::MeshService::NewStub(channel_);
  scenes_ = v1::SceneService::NewStub(channel_);
  info_ = v1::ServerService::NewStub(channel_);
}

grpc::Status TestEnv::Upload(const v1::MeshHeader& header, std::string_view bytes, v1::Mesh* mesh) {
  constexpr size_t kPartBytes = size_t{64} << 10;
  grpc::ClientContext context;
  const auto writer = meshes_->UploadMesh(&context, mesh);
  v1::UploadMeshRequest request;
  *request.mutable_header() = header;
  bool open = writer->Write(request);
  for (size_t at = 0; open && at < bytes.size(); at += kPartBytes) {
    request.set_data(std::string(bytes.substr(at, kPartBytes)));
    open = writer->Write(request);
  }
  writer->WritesDone();
  return writer->Finish();
}

v1::Mesh TestEnv::UploadCube(double edge) {
  const std::string obj = CubeObj(edge);
  v1::Mesh mesh;
  const grpc::Status status = Upload(ObjHeader(obj), obj, &mesh);
  EXPECT_TRUE(status.ok()) << status.error_message();
  return mesh;
}

}  // namespace latticed::testing
