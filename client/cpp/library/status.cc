// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/library/status.h"

#include <map>
#include <string>
#include <utility>

#include "absl/strings/numbers.h"
#include "core/base/error.h"
#include "google/rpc/error_details.pb.h"
#include "google/rpc/error_info.pb.h"

namespace latticed::client {
namespace {

constexpr char kDomain[] = "latticed";
constexpr char kRequestId[] = "latticed-request-id";

// Removes a number from the metadata, for a field of error::Details. 0 if there is none.
uint64_t TakeNumber(std::map<std::string, std::string>& metadata, const std::string& key) {
  const auto entry = metadata.extract(key);
  uint64_t number = 0;
  if (entry.empty() || !absl::SimpleAtoi(entry.mapped(), &number)) return 0;
  return number;
}

void Read(const google::rpc::ErrorInfo& info, error::Details& details) {
  details.reason = info.reason();
  for (const auto& [key, value] : info.metadata()) details.metadata[key] = value;
  details.asked_bytes = TakeNumber(details.metadata, "asked_bytes");
  details.free_bytes = TakeNumber(details.metadata, "free_bytes");
}

// All violations, for example "memory: asked 5 bytes, free 3 bytes".
std::string Describe(const google::rpc::QuotaFailure& quota) {
  std::string text;
  for (const auto& violation : quota.violations()) {
    if (!text.empty()) text += "; ";
    text += violation.subject() + ": " + violation.description();
  }
  return text;
}

error::Details DetailsIn(const google::rpc::Status& status) {
  error::Details details;
  for (const auto& any : status.details()) {
    google::rpc::ErrorInfo info;
    google::rpc::BadRequest bad_request;
    google::rpc::RetryInfo retry;
    google::rpc::QuotaFailure quota;
    if (any.UnpackTo(&info) && info.domain() == kDomain) {
      Read(info, details);
    } else if (any.UnpackTo(&bad_request) && bad_request.field_violations_size() > 0) {
      details.field = bad_request.field_violations(0).field();
    } else if (any.UnpackTo(&quota) && details.asked_bytes == 0) {  // otherwise ErrorInfo has it
      details.metadata["quota"] = Describe(quota);
    } else if (any.UnpackTo(&retry)) {
      details.retry_after_ms = static_cast<uint32_t>(retry.retry_delay().seconds() * 1000 +
                                                     retry.retry_delay().nanos() / 1'000'000);
    }
  }
  return details;
}

absl::Status WithRequestId(absl::Status status,
                           const std::multimap<grpc::string_ref, grpc::string_ref>& metadata) {
  const auto id = metadata.find(kRequestId);
  if (status.ok() || id == metadata.end()) return status;
  error::Details details = error::DetailsOf(status);
  details.metadata["request_id"] = std::string(id->second.data(), id->second.size());
  return error::WithDetails(std::move(status), details);
}

}  // namespace

absl::Status FromRpc(const google::rpc::Status& status) {
  if (status.code() == 0) return absl::OkStatus();
  absl::Status result(static_cast<absl::StatusCode>(status.code()), status.message());
  if (status.details_size() == 0) return result;
  error::Details details = DetailsIn(status);
  // A proxy's error has no reason of latticed, but its field or retry delay is used.
  if (details.reason.empty()) details.reason = error::DetailsOf(result).reason;
  return error::WithDetails(std::move(result), details);
}

absl::Status FromGrpc(const grpc::Status& status) {
  if (status.ok()) return absl::OkStatus();
  google::rpc::Status rpc;
  if (!rpc.ParseFromString(status.error_details())) rpc.Clear();
  rpc.set_code(status.error_code());
  rpc.set_message(status.error_message());
  return FromRpc(rpc);
}

absl::Status FromGrpc(const grpc::Status& status, const grpc::ClientContext& context) {
  return WithRequestId(FromGrpc(status), context.GetServerTrailingMetadata());
}

absl::Status FromRpc(const google::rpc::Status& status, const grpc::ClientContext& context) {
  return WithRequestId(FromRpc(status), context.GetServerInitialMetadata());
}

absl::Status Stopped() { return absl::CancelledError("the client was told to stop"); }

}  // namespace latticed::client
