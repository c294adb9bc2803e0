// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The load generator finds a wrong surface: at the end, or in one update that the next one corrected.
#include <grpcpp/grpcpp.h>
#include <grpcpp/support/client_interceptor.h>

#include "client/cpp/load/load_run.h"
#include "client/cpp/load/surface_verifier.h"
#include "core/mesh/mesh_io.h"
#include "tests/client/latticectl_server_fixture.h"

namespace latticed::client {
namespace {

using ::latticed::testing::StatusIs;
using ::testing::HasSubstr;

class SurfaceVerifierTest : public LatticectlServer {
 protected:
  void SetUp() override {
    LatticectlServer::SetUp();
    Run({"scene", "create", Path("vase.obj"), "--id", "scene-one", "--segments", "3"});
    const auto mesh = ReadMeshFile(Path("vase.obj"));
    ASSERT_OK(mesh);
    mesh_ = std::make_shared<const MeshFile>(*mesh);
    Move();
  }
  void Move() const {
    Run({"edit", "move", "scene-one", "--point", "1,1,1", "--point", "2,1,2", "--by", "0.2,0,0"});
  }
  Surface Fetch() const {
    v1::GetUpdateRequest request;
    request.set_scene("scene-one");
    request.mutable_view()->set_normals(v1::NORMAL_MODE_SMOOTH);
    auto surface = client_->GetUpdate(request);
    EXPECT_OK(surface);
    return surface.ok() ? *std::move(surface) : Surface();
  }

  SurfaceVerifier Verifier(std::shared_ptr<const MeshFile> mesh) const {
    return {client_.get(), "scene-one", std::move(mesh), /*fused=*/true};
  }

  std::shared_ptr<const MeshFile> mesh_;
  const std::unique_ptr<Client> client_ = Client::Connect({.address = address()});
};

TEST_F(SurfaceVerifierTest, FindsNormalsThatAreNotTheMeshes) {
  auto other = ParseMesh(*mesh_);
  ASSERT_OK(other);
  for (Vec3d& position : other->positions) position.z *= 3;
  SurfaceVerifier verifier = Verifier(
      std::make_shared<const MeshFile>(MeshFile{"other.obj", MeshFormat::kObj, WriteObj(*other)}));
  const absl::Status status = verifier.Check(Fetch(), 0);
  EXPECT_THAT(status, StatusIs(absl::StatusCode::kDataLoss));
  EXPECT_THAT(std::string(status.message()), HasSubstr("a normal of revision 1 "));
}

TEST_F(SurfaceVerifierTest, AnEditMeanwhileIsNoMismatch) {
  const Surface surface = Fetch();
  Move();
  SurfaceVerifier verifier = Verifier(mesh_);
  EXPECT_THAT(verifier.Check(surface, 0), StatusIs(absl::StatusCode::kAborted));
}

// Moves the first point of chunk 1, which is among those that are kept of the second timed update,
// where a Deform stream brings it at `revision`.
class ChunkSpoiler final : public grpc::experimental::Interceptor {
 public:
  explicit ChunkSpoiler(uint64_t revision) : revision_(revision) {}
  void Intercept(grpc::experimental::InterceptorBatchMethods* methods) override {
    if (methods->QueryInterceptionHookPoint(
            grpc::experimental::InterceptionHookPoints::POST_RECV_MESSAGE)) {
      auto* event = static_cast<v1::SceneEvent*>(methods->GetRecvMessage());
      if (event != nullptr && event->has_chunks()) Spoil(*event->mutable_chunks());
    }
    methods->Proceed();
  }

 private:
  void Spoil(v1::Chunks& chunks) const {
    for (v1::Chunk& chunk : *chunks.mutable_chunks()) {
      if (chunk.index() == 1 && chunk.revision() == revision_) (*chunk.mutable_data())[1] ^= 8;
    }
  }
  const uint64_t revision_;
};

class SpoilerFactory final : public grpc::experimental::ClientInterceptorFactoryInterface {
 public:
  explicit SpoilerFactory(uint64_t revision) : revision_(revision) {}
  grpc::experimental::Interceptor* CreateClientInterceptor(
      grpc::experimental::ClientRpcInfo* info) override {
    const bool deform = std::string_view(info->method()).ends_with("/Deform");
    return deform ? new ChunkSpoiler(revision_) : nullptr;
  }

 private:
  const uint64_t revision_;
};

class LoadVerification : public LatticectlServer {
 protected:
  // Four edits of one editor, at revisions 5 to 8, whose updates come through the spoiler.
  absl::StatusOr<LoadReport> RunSpoilt(uint64_t revision) const {
    Run({"scene", "create", Path("vase.obj"), "--id", "scene-spoilt"});
    auto mesh = ReadMeshFile(Path("vase.obj"));
    if (!mesh.ok()) return mesh.status();
    LoadPlan plan{.edits = 4};
    plan.view.set_segments(2);
    plan.view.set_encoding(v1::ENCODING_QUANTISED);
    const auto new_client = [this, revision] {
      std::vector<std::unique_ptr<grpc::experimental::ClientInterceptorFactoryInterface>> spoilers;
      spoilers.push_back(std::make_unique<SpoilerFactory>(revision));
      return std::make_unique<Client>(
          grpc::experimental::CreateCustomChannelWithInterceptors(
              address(), grpc::InsecureChannelCredentials(), {}, std::move(spoilers)),
          "");
    };
    LoadRun run(plan,
                {LoadScene{"scene-spoilt", std::make_shared<const MeshFile>(*std::move(mesh))}},
                new_client, {}, {});
    return run.Run([](uint64_t, uint64_t) {});
  }
};

TEST_F(LoadVerification, FindsAChunkThatWasWrongInOneTimedUpdate) {
  const auto report = RunSpoilt(6);
  EXPECT_THAT(report.status(), StatusIs(absl::StatusCode::kDataLoss));
  EXPECT_THAT(std::string(report.status().message()), HasSubstr("a point of revision 6 is off"));
}

TEST_F(LoadVerification, FindsNothingWhereNothingIsWrong) {
  const auto report = RunSpoilt(100);
  ASSERT_OK(report);
  EXPECT_EQ(report->verified.updates, 1u + 3u);
}

}  // namespace
}  // namespace latticed::client
