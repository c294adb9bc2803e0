// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/wire/grpc_status.h"

#include <string>
#include <string_view>

#include "core/base/error.h"
#include "core/base/utf8.h"
#include "fmt/format.h"
#include "google/rpc/error_details.pb.h"
#include "google/rpc/error_info.pb.h"

namespace latticed {
namespace {

constexpr char kDomain[] = "latticed";
constexpr size_t kMaxMessageBytes = 1'024;
// A status is sent in trailers of at most 8 KiB: the message, which escaping may triple, and the details in
// base64, which contain the message twice more.
constexpr size_t kMaxFieldBytes = 256;
constexpr size_t kMaxMetadataBytes = 1'024;
constexpr char kAskedBytes[] = "asked_bytes";
constexpr char kFreeBytes[] = "free_bytes";

// Clients cannot read a status that is not UTF-8, and a message may repeat text that the client sent.
std::string Truncated(std::string_view text, size_t most) {
  const std::string valid = ValidUtf8(text);
  return std::string(CutUtf8(valid, most));
}

void AddErrorInfo(const error::Details& details, google::rpc::Status& status) {
  google::rpc::ErrorInfo info;
  info.set_domain(kDomain);
  info.set_reason(details.reason);
  size_t bytes = 0;
  for (const auto& [key, value] : details.metadata) {
    bytes += key.size() + value.size();
    if (bytes > kMaxMetadataBytes) break;
    (*info.mutable_metadata())[key] = ValidUtf8(value);
  }
  if (details.asked_bytes > 0) {
    (*info.mutable_metadata())[kAskedBytes] = std::to_string(details.asked_bytes);
    (*info.mutable_metadata())[kFreeBytes] = std::to_string(details.free_bytes);
  }
  status.add_details()->PackFrom(info);
}

void AddBadRequest(const error::Details& details, google::rpc::Status& status) {
  google::rpc::BadRequest bad_request;
  auto* violation = bad_request.add_field_violations();
  violation->set_field(Truncated(details.field, kMaxFieldBytes));
  violation->set_description(status.message());
  status.add_details()->PackFrom(bad_request);
}

void AddQuotaFailure(const error::Details& details, google::rpc::Status& status) {
  google::rpc::QuotaFailure quota;
  auto* violation = quota.add_violations();
  if (details.reason == error::kQuotaExceededReason) {
    const auto& of = details.metadata;
    violation->set_subject("tenant:" + of.at("what"));
    violation->set_description(fmt::format("asked {}, used {}, allowed {}", of.at("asked"),
                                           of.at("used"), of.at("allowed")));
  } else {
    violation->set_subject("memory");
    violation->set_description(
        fmt::format("asked {} bytes, free {} bytes", details.asked_bytes, details.free_bytes));
  }
  status.add_details()->PackFrom(quota);
}

void AddRetryInfo(const error::Details& details, google::rpc::Status& status) {
  google::rpc::RetryInfo retry;
  retry.mutable_retry_delay()->set_seconds(details.retry_after_ms / 1'000);
  retry.mutable_retry_delay()->set_nanos(static_cast<int32_t>(details.retry_after_ms % 1'000) *
                                         1'000'000);
  status.add_details()->PackFrom(retry);
}

}  // namespace

google::rpc::Status ToRpcStatus(const absl::Status& status) {
  google::rpc::Status rpc;
  if (status.ok()) return rpc;
  const error::Details details = error::DetailsOf(status);
  // The codes of absl and gRPC have the same numbers.
  rpc.set_code(static_cast<int32_t>(status.code()));
  rpc.set_message(Truncated(std::string_view(status.message().data(), status.message().size()),
                            kMaxMessageBytes));
  AddErrorInfo(details, rpc);
  if (!details.field.empty()) AddBadRequest(details, rpc);
  if (details.asked_bytes > 0 || details.reason == error::kQuotaExceededReason)
    AddQuotaFailure(details, rpc);
  if (details.retry_after_ms > 0) AddRetryInfo(details, rpc);
  return rpc;
}

grpc::Status ToGrpcStatus(const absl::Status& status) {
  if (status.ok()) return grpc::Status::OK;
  const google::rpc::Status rpc = ToRpcStatus(status);
  return grpc::Status(static_cast<grpc::StatusCode>(rpc.code()), rpc.message(),
                      rpc.SerializeAsString());
}

google::rpc::Status ToRpcStatus(const grpc::Status& status) {
  google::rpc::Status rpc;
  if (!rpc.ParseFromString(status.error_details())) rpc.clear_details();
  rpc.set_code(status.error_code());
  rpc.set_message(status.error_message());
  return rpc;
}

std::string ReasonOf(const grpc::Status& status) {
  google::rpc::Status rpc;
  if (!rpc.ParseFromString(status.error_details())) return "";
  for (const auto& detail : rpc.details()) {
    if (google::rpc::ErrorInfo info; detail.UnpackTo(&info)) return info.reason();
  }
  return "";
}

}  // namespace latticed
