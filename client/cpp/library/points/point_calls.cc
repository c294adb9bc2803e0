// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The rpcs of latticed_client.h that stream points.
#include <cstring>
#include <functional>
#include <string_view>
#include <utility>

#include "client/cpp/library/latticed_client.h"
#include "client/cpp/library/retries/with_retries.h"
#include "client/cpp/library/status.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

static_assert(sizeof(Vec3d) == 3 * sizeof(double), "vectors are sent as they are");

std::vector<Vec3d> VectorsOf(std::string_view bytes) {
  std::vector<Vec3d> vectors(bytes.size() / sizeof(Vec3d));
  std::memcpy(vectors.data(), bytes.data(), vectors.size() * sizeof(Vec3d));
  return vectors;
}

}  // namespace

template <typename Request, typename Header, typename Response>
absl::Status Client::SendPoints(std::unique_ptr<grpc::ClientWriter<Request>> (
                                    v1::PointSetService::Stub::*method)(grpc::ClientContext*,
                                                                        Response*),
                                const Header& header, std::string_view bytes, Response& response) {
  const auto context = NewContext(header.scene());
  const std::stop_callback cancel(stop_, [&context] { context->TryCancel(); });
  const auto writer = (points_.get()->*method)(context.get(), &response);
  Request request;
  *request.mutable_header() = header;
  bool open = writer->Write(request);
  for (size_t sent = 0; open && sent < bytes.size();) {
    const std::string_view part = bytes.substr(sent, limits::kMaxPartBytes);
    request.set_data(part.data(), part.size());
    open = writer->Write(request);
    sent += part.size();
  }
  if (open) writer->WritesDone();
  return FromGrpc(writer->Finish(), *context);
}

absl::StatusOr<v1::PointSet> Client::CreatePointSet(const v1::PointSetHeader& header,
                                                    std::span<const double> data) {
  v1::PointSet set;
  const std::string_view bytes(reinterpret_cast<const char*>(data.data()), data.size_bytes());
  LATTICED_RETURN_IF_ERROR(SendPoints<v1::CreatePointSetRequest>(
      &v1::PointSetService::Stub::CreatePointSet, header, bytes, set));
  return set;
}

absl::StatusOr<Client::Gradients> Client::ApplyJacobianTranspose(
    const v1::CotangentHeader& header, std::span<const Vec3d> cotangents) {
  v1::PointGradients answer;
  const std::string_view bytes(reinterpret_cast<const char*>(cotangents.data()),
                               cotangents.size_bytes());
  LATTICED_RETURN_IF_ERROR(WithRetries(reachability_.get(), *channel_, stop_, [&] {
    answer.Clear();
    return SendPoints<v1::ApplyJacobianTransposeRequest>(
        &v1::PointSetService::Stub::ApplyJacobianTranspose, header, bytes, answer);
  }));
  return Gradients{answer.revision(), answer.structure_id(), VectorsOf(answer.gradients())};
}

template <typename Request>
absl::StatusOr<Client::PointVectors> Client::ReceivePoints(
    StreamMethod<v1::PointSetService::Stub, Request, v1::PointSetData> method,
    const Request& request) {
  PointVectors result;
  std::string bytes;
  LATTICED_RETURN_IF_ERROR(WithRetries(reachability_.get(), *channel_, stop_, [&] {
    result.header.Clear();
    bytes.clear();
    const auto context = NewContext(request.scene());
    const std::stop_callback cancel(stop_, [&context] { context->TryCancel(); });
    const auto reader = (points_.get()->*method)(context.get(), request);
    for (v1::PointSetData part; reader->Read(&part);) {
      if (part.has_header()) result.header = part.header();
      bytes += part.data();
    }
    return FromGrpc(reader->Finish(), *context);
  }));
  const uint64_t expected = result.header.points() * result.header.directions() *
                            (result.header.with_normals() ? 2 : 1) * sizeof(Vec3d);
  if (bytes.size() != expected) {
    return absl::DataLossError(
        fmt::format("points of {} bytes ended after {}", expected, bytes.size()));
  }
  result.vectors = VectorsOf(bytes);
  return result;
}

absl::StatusOr<Client::PointVectors> Client::DeformPointSet(
    const v1::DeformPointSetRequest& request) {
  return ReceivePoints<v1::DeformPointSetRequest>(&v1::PointSetService::Stub::DeformPointSet,
                                                  request);
}

absl::StatusOr<Client::PointVectors> Client::ApplyJacobian(
    const v1::ApplyJacobianRequest& request) {
  return ReceivePoints<v1::ApplyJacobianRequest>(&v1::PointSetService::Stub::ApplyJacobian,
                                                 request);
}

}  // namespace latticed::client
