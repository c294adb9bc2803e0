// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/server/points/point_set_client.h"

#include <chrono>
#include <cstring>

#include "client/cpp/library/status.h"
#include "core/base/limits.h"

namespace latticed::testing {
namespace {

template <class Message, class Header>
std::vector<Message> MessagesOf(const Header& header, const std::string& data, size_t part_bytes) {
  std::vector<Message> messages(1);
  *messages.front().mutable_header() = header;
  for (size_t at = 0; at < data.size(); at += part_bytes) {
    messages.emplace_back().set_data(data.substr(at, part_bytes));
  }
  return messages;
}

template <class Writer, class Message>
absl::Status Send(Writer& writer, const std::vector<Message>& messages) {
  for (const Message& message : messages) {
    if (!writer.Write(message)) break;  // the status says why
  }
  writer.WritesDone();
  return client::FromGrpc(writer.Finish());
}

}  // namespace

std::string BytesOf(const std::vector<Vec3d>& vectors) {
  return {reinterpret_cast<const char*>(vectors.data()), vectors.size() * sizeof(Vec3d)};
}

std::vector<Vec3d> VectorsOf(const std::string& bytes) {
  EXPECT_EQ(bytes.size() % sizeof(Vec3d), 0u);
  std::vector<Vec3d> vectors(bytes.size() / sizeof(Vec3d));
  std::memcpy(vectors.data(), bytes.data(), bytes.size());
  return vectors;
}

void PointSetClient::Prepare(grpc::ClientContext& context) const {
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::minutes(1));
  for (const auto& [name, value] : metadata_) context.AddMetadata(name, value);
}

absl::StatusOr<v1::PointSet> PointSetClient::Create(
    const std::vector<v1::CreatePointSetRequest>& messages) {
  grpc::ClientContext context;
  Prepare(context);
  v1::PointSet set;
  const auto writer = stub_->CreatePointSet(&context, &set);
  const absl::Status status = Send(*writer, messages);
  if (!status.ok()) return status;
  return set;
}

absl::StatusOr<v1::PointSet> PointSetClient::Create(const v1::PointSetHeader& header,
                                                    const std::string& data, size_t part_bytes) {
  return Create(MessagesOf<v1::CreatePointSetRequest>(header, data, part_bytes));
}

absl::StatusOr<v1::PointSet> PointSetClient::CreateWorld(const std::vector<Vec3d>& points,
                                                         const std::vector<Vec3d>& normals,
                                                         size_t part_bytes) {
  auto header = For<v1::PointSetHeader>();
  header.mutable_world()->set_points(points.size());
  header.mutable_world()->set_with_normals(!normals.empty());
  return Create(header, BytesOf(points) + BytesOf(normals), part_bytes);
}

template <class Request>
absl::StatusOr<PointSetClient::Values> PointSetClient::Read(
    std::unique_ptr<grpc::ClientReader<v1::PointSetData>> (v1::PointSetService::Stub::*method)(
        grpc::ClientContext*, const Request&),
    const Request& request) {
  grpc::ClientContext context;
  Prepare(context);
  const auto reader = ((*stub_).*method)(&context, request);
  Values values;
  std::string bytes;
  v1::PointSetData part;
  for (bool first = true; reader->Read(&part); first = false) {
    EXPECT_EQ(part.has_header(), first);
    EXPECT_LE(part.ByteSizeLong(), limits::kMaxMessageBytes);
    if (part.has_header()) values.header = part.header();
    bytes += part.data();
    ++values.parts;
  }
  const absl::Status status = client::FromGrpc(reader->Finish());
  if (!status.ok()) return status;
  values.vectors = VectorsOf(bytes);
  return values;
}

absl::StatusOr<PointSetClient::Values> PointSetClient::Deform(
    const v1::DeformPointSetRequest& request) {
  return Read(&v1::PointSetService::Stub::DeformPointSet, request);
}

absl::StatusOr<PointSetClient::Values> PointSetClient::Deform(const v1::PointSet& set,
                                                              bool with_normals) {
  auto request = For<v1::DeformPointSetRequest>();
  request.set_point_set(set.id());
  request.set_with_normals(with_normals);
  return Deform(request);
}

absl::StatusOr<PointSetClient::Values> PointSetClient::ApplyJacobian(
    const v1::ApplyJacobianRequest& request) {
  return Read(&v1::PointSetService::Stub::ApplyJacobian, request);
}

absl::StatusOr<v1::PointGradients> PointSetClient::ApplyTranspose(
    const std::vector<v1::ApplyJacobianTransposeRequest>& messages) {
  grpc::ClientContext context;
  Prepare(context);
  v1::PointGradients gradients;
  const auto writer = stub_->ApplyJacobianTranspose(&context, &gradients);
  const absl::Status status = Send(*writer, messages);
  if (!status.ok()) return status;
  return gradients;
}

absl::StatusOr<v1::PointGradients> PointSetClient::ApplyTranspose(const v1::CotangentHeader& header,
                                                                  const std::string& data,
                                                                  size_t part_bytes) {
  return ApplyTranspose(MessagesOf<v1::ApplyJacobianTransposeRequest>(header, data, part_bytes));
}

absl::StatusOr<v1::ListPointSetsResponse> PointSetClient::List(const std::string& scene) {
  grpc::ClientContext context;
  Prepare(context);
  v1::ListPointSetsResponse response;
  const absl::Status status = client::FromGrpc(
      stub_->ListPointSets(&context, For<v1::ListPointSetsRequest>(scene), &response));
  if (!status.ok()) return status;
  return response;
}

absl::Status PointSetClient::Delete(const std::string& point_set) {
  grpc::ClientContext context;
  Prepare(context);
  auto request = For<v1::DeletePointSetRequest>();
  request.set_point_set(point_set);
  v1::DeletePointSetResponse response;
  return client::FromGrpc(stub_->DeletePointSet(&context, request, &response));
}

}  // namespace latticed::testing
