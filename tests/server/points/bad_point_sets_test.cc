// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Every refusal of PointSetService.
#include <cmath>

#include "core/base/limits.h"
#include "tests/server/points/point_set_client.h"
#include "tests/server/support/server_test.h"

namespace latticed::testing {
namespace {

using Code = absl::StatusCode;

class BadPointSetsTest : public OneSceneTest {
 protected:
  void SetUp() override {
    OneSceneTest::SetUp();
    client_ = std::make_unique<PointSetClient>(server_->channel());
    ASSERT_OK_AND_ASSIGN(set_, client_->CreateWorld(points_));
  }
  static v1::PointSetHeader World(uint64_t points) {
    auto header = For<v1::PointSetHeader>();
    header.mutable_world()->set_points(points);
    return header;
  }
  template <class Request>
  Request OfSet() const {
    auto request = For<Request>();
    request.set_point_set(set_.id());
    return request;
  }
  void ExpectBadSource(const v1::PointSetHeader& header, const std::string& data,
                       const std::string& reason, const std::string& field) {
    SCOPED_TRACE(header.ShortDebugString());
    ExpectRefused(client_->Create(header, data).status(), Code::kInvalidArgument, reason, field);
  }

  std::unique_ptr<PointSetClient> client_;
  const std::vector<Vec3d> points_{{1, 1, 0}, {0.5, 0.5, 0}};
  v1::PointSet set_;
};

TEST_F(BadPointSetsTest, Headers) {
  ExpectBadSource(For<v1::PointSetHeader>(), "", "INVALID_FIELD", "header");
  ExpectBadSource(World(0), "", "OUT_OF_RANGE", "header.world.points");
  ExpectBadSource(World(limits::kMaxPointSetPoints + 1), "", "OUT_OF_RANGE", "header.world.points");
  auto surface = For<v1::PointSetHeader>();
  surface.mutable_surface();
  ExpectBadSource(surface, "", "OUT_OF_RANGE", "header.surface.points");
  auto view = For<v1::PointSetHeader>();
  view.mutable_view()->set_segments(33);
  EXPECT_THAT(client_->Create(view, "").status(), StatusIs(Code::kInvalidArgument));
  view.mutable_view()->set_segments(0);
  view.mutable_view()->set_tolerance(0.1);
  ExpectBadSource(view, "", "UNSUPPORTED", "header.view.tolerance");
  view.mutable_view()->clear_tolerance();
  view.mutable_view()->set_encoding(v1::ENCODING_PATCHES);
  ExpectBadSource(view, "", "UNSUPPORTED", "header.view.encoding");
  ExpectBadSource(For<v1::PointSetHeader>(""), "", "INVALID_FIELD", "scene");
  ExpectRefused(client_->Create(For<v1::PointSetHeader>("none"), "").status(), Code::kNotFound,
                "NOT_FOUND");
}

TEST_F(BadPointSetsTest, Data) {
  const std::string two = BytesOf(points_);
  ExpectBadSource(World(3), two, "SIZE_MISMATCH", "data");
  ExpectBadSource(World(1), two, "SIZE_MISMATCH", "data");
  ExpectBadSource(World(2), "1234567", "INVALID_FIELD", "data");
  ExpectRefused(client_
                    ->Create(World(200'000), std::string(limits::kMaxPartBytes + 8, '\0'),
                             limits::kMaxPartBytes + 8)
                    .status(),
                Code::kInvalidArgument, "OUT_OF_RANGE", "data");
  ExpectBadSource(World(2), BytesOf({{0, 0, 0}, {0, std::nan(""), 0}}), "NOT_FINITE",
                  "data.positions[1]");
  ExpectBadSource(World(1), BytesOf({{0, 2e15, 0}}), "OUT_OF_RANGE", "data.positions");
  auto with_normals = World(1);
  with_normals.mutable_world()->set_with_normals(true);
  ExpectBadSource(with_normals, BytesOf({{}, {INFINITY, 0, 0}}), "NOT_FINITE", "data.normals[0]");
  auto surface = For<v1::PointSetHeader>();
  surface.mutable_surface()->set_points(1);
  ExpectBadSource(surface, std::string(40, '\x7f'), "OUT_OF_RANGE", "data.points[0].face");
}

TEST_F(BadPointSetsTest, Streams) {
  ExpectRefused(client_->Create(std::vector<v1::CreatePointSetRequest>{}).status(),
                Code::kFailedPrecondition, "STREAM_NOT_OPENED");
  std::vector<v1::CreatePointSetRequest> messages(2);
  messages[0].set_data("12345678");
  ExpectRefused(client_->Create(messages).status(), Code::kFailedPrecondition, "STREAM_NOT_OPENED");
  for (auto& message : messages) *message.mutable_header() = World(2);
  ExpectRefused(client_->Create(messages).status(), Code::kInvalidArgument, "INVALID_FIELD",
                "header");
  messages[1].clear_message();
  ExpectRefused(client_->Create(messages).status(), Code::kInvalidArgument, "INVALID_FIELD",
                "header");
  messages[1].set_data("");
  ExpectRefused(client_->Create(messages).status(), Code::kInvalidArgument, "OUT_OF_RANGE", "data");
  ExpectRefused(client_->ApplyTranspose(std::vector<v1::ApplyJacobianTransposeRequest>{}).status(),
                Code::kFailedPrecondition, "STREAM_NOT_OPENED");
}

TEST_F(BadPointSetsTest, AHeaderMustComeInTime) {
  Options options;
  options.first_message_timeout = absl::Milliseconds(100);
  SceneFixture::StartServer(options);
  const auto stub = v1::PointSetService::NewStub(server_->channel());
  grpc::ClientContext context;
  v1::PointSet set;
  const auto writer = stub->CreatePointSet(&context, &set);
  ExpectRefused(client::FromGrpc(writer->Finish()), Code::kFailedPrecondition, "STREAM_NOT_OPENED");
}

TEST_F(BadPointSetsTest, Deform) {
  auto request = For<v1::DeformPointSetRequest>();
  ExpectRefused(client_->Deform(request).status(), Code::kInvalidArgument, "INVALID_FIELD",
                "point_set");
  request = OfSet<v1::DeformPointSetRequest>();
  request.set_with_normals(true);
  ExpectRefused(client_->Deform(request).status(), Code::kInvalidArgument, "INVALID_FIELD",
                "with_normals");
  request.set_with_normals(false);
  request.set_revision(1);
  const absl::Status changed = client_->Deform(request).status();
  ExpectRefused(changed, Code::kAborted, "REVISION_CHANGED");
  EXPECT_EQ(error::DetailsOf(changed).metadata.at("revision"), "0");
}

TEST_F(BadPointSetsTest, ApplyJacobian) {
  auto request = OfSet<v1::ApplyJacobianRequest>();
  const auto expect = [&](const std::string& reason, const std::string& field) {
    ExpectRefused(client_->ApplyJacobian(request).status(), Code::kInvalidArgument, reason, field);
  };
  expect("INVALID_FIELD", "tangents");
  request.set_tangents(std::string(63 * 24, '\0'));
  expect("INVALID_FIELD", "tangents");
  request.set_tangents(BytesOf(std::vector<Vec3d>(64, Vec3d{0, 0, NAN})));
  expect("NOT_FINITE", "tangents[0]");
  request.set_tangents(std::string(24, '\0'));
  request.add_indices(64);
  expect("OUT_OF_RANGE", "indices[0]");
  request.set_indices(0, 63);
  request.set_tangents(std::string(65 * 24, '\0'));
  expect("OUT_OF_RANGE", "tangents");
  request.add_indices(63);
  request.set_tangents(std::string(2 * 24, '\0'));
  expect("INVALID_FIELD", "indices[1]");
}

TEST_F(BadPointSetsTest, ApplyTranspose) {
  auto header = OfSet<v1::CotangentHeader>();
  const auto expect = [&](const std::string& data, const std::string& reason,
                          const std::string& field) {
    ExpectRefused(client_->ApplyTranspose(header, data).status(), Code::kInvalidArgument, reason,
                  field);
  };
  expect(BytesOf({{}}), "SIZE_MISMATCH", "data");
  expect(BytesOf({{}, {0, 0, -INFINITY}}), "NOT_FINITE", "data.cotangents[1]");
  header.set_directions(65);
  expect("", "OUT_OF_RANGE", "header.directions");
  header.set_directions(0);
  header.set_with_normals(true);
  expect("", "INVALID_FIELD", "header.with_normals");
  header.set_with_normals(false);
  header.set_revision(9);
  ExpectRefused(client_->ApplyTranspose(header, "").status(), Code::kAborted, "REVISION_CHANGED");
}

}  // namespace
}  // namespace latticed::testing
