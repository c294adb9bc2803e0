// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Calls of PointSetService through the real stub, on the scene kScene.
#ifndef LATTICED_TESTS_SERVER_POINTS_POINT_SET_CLIENT_H_
#define LATTICED_TESTS_SERVER_POINTS_POINT_SET_CLIENT_H_

#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/vec.h"
#include "latticed/v1/points.grpc.pb.h"
#include "tests/server/support/server_test.h"

namespace latticed::testing {

[[nodiscard]] std::string BytesOf(const std::vector<Vec3d>& vectors);
[[nodiscard]] std::vector<Vec3d> VectorsOf(const std::string& bytes);

class PointSetClient {
 public:
  struct Values {
    v1::PointSetDataHeader header;
    std::vector<Vec3d> vectors;
    size_t parts = 0;
  };

  explicit PointSetClient(const std::shared_ptr<grpc::Channel>& channel, Metadata metadata = {})
      : stub_(v1::PointSetService::NewStub(channel)), metadata_(std::move(metadata)) {}

  // Sends the messages one after the other, then half-closes.
  absl::StatusOr<v1::PointSet> Create(const std::vector<v1::CreatePointSetRequest>& messages);
  absl::StatusOr<v1::PointSet> Create(const v1::PointSetHeader& header, const std::string& data,
                                      size_t part_bytes = 768 << 10);
  absl::StatusOr<v1::PointSet> CreateWorld(const std::vector<Vec3d>& points,
                                           const std::vector<Vec3d>& normals = {},
                                           size_t part_bytes = 768 << 10);
  absl::StatusOr<Values> Deform(const v1::DeformPointSetRequest& request);
  absl::StatusOr<Values> Deform(const v1::PointSet& set, bool with_normals = false);
  absl::StatusOr<Values> ApplyJacobian(const v1::ApplyJacobianRequest& request);
  absl::StatusOr<v1::PointGradients> ApplyTranspose(
      const std::vector<v1::ApplyJacobianTransposeRequest>& messages);
  absl::StatusOr<v1::PointGradients> ApplyTranspose(const v1::CotangentHeader& header,
                                                    const std::string& data,
                                                    size_t part_bytes = 768 << 10);
  absl::StatusOr<v1::ListPointSetsResponse> List(const std::string& scene = kScene);
  absl::Status Delete(const std::string& point_set);

 private:
  void Prepare(grpc::ClientContext& context) const;
  template <class Request>
  absl::StatusOr<Values> Read(std::unique_ptr<grpc::ClientReader<v1::PointSetData>> (
                                  v1::PointSetService::Stub::*method)(grpc::ClientContext*,
                                                                      const Request&),
                              const Request& request);

  std::unique_ptr<v1::PointSetService::Stub> stub_;
  Metadata metadata_;
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_POINTS_POINT_SET_CLIENT_H_
