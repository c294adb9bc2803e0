// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/wire/grpc_status.h"

#include <set>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "absl/status/status.h"
#include "client/cpp/library/status.h"
#include "core/base/error.h"
#include "google/rpc/error_details.pb.h"
#include "google/rpc/error_info.pb.h"
#include "latticed/v1/common.pb.h"

namespace latticed {
namespace {

using ::testing::HasSubstr;

google::rpc::Status ParseDetails(const grpc::Status& status) {
  google::rpc::Status rpc;
  EXPECT_TRUE(rpc.ParseFromString(status.error_details()));
  return rpc;
}

// Returns the first detail of type T, and in `count` how many there are.
template <typename T>
T Detail(const google::rpc::Status& rpc, int& count) {
  T first, any;
  count = 0;
  for (const auto& detail : rpc.details()) {
    if (detail.UnpackTo(&any) && count++ == 0) first = any;
  }
  return first;
}

template <typename T>
int Count(const google::rpc::Status& rpc) {
  int count = 0;
  (void)Detail<T>(rpc, count);
  return count;
}

google::rpc::ErrorInfo InfoOf(const google::rpc::Status& rpc) {
  int count = 0;
  auto info = Detail<google::rpc::ErrorInfo>(rpc, count);
  EXPECT_EQ(count, 1);
  EXPECT_EQ(info.domain(), "latticed");
  return info;
}

TEST(GrpcStatus, OkIsOkWithoutDetails) {
  EXPECT_TRUE(ToGrpcStatus(absl::OkStatus()).ok());
  EXPECT_EQ(ToRpcStatus(absl::OkStatus()).ByteSizeLong(), 0U);
}

TEST(GrpcStatus, FieldErrorsCarryTheFieldPath) {
  const grpc::Status status = ToGrpcStatus(error::OutOfRange("lattice.degree.u", 4, 1, 3));

  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(status.error_message(), "lattice.degree.u: got 4, allowed is 1 to 3");
  const auto rpc = ParseDetails(status);
  EXPECT_EQ(rpc.code(), 3);
  EXPECT_EQ(rpc.message(), status.error_message());
  EXPECT_EQ(InfoOf(rpc).reason(), "OUT_OF_RANGE");
  int count = 0;
  const auto bad_request = Detail<google::rpc::BadRequest>(rpc, count);
  ASSERT_EQ(count, 1);
  ASSERT_EQ(bad_request.field_violations_size(), 1);
  EXPECT_EQ(bad_request.field_violations(0).field(), "lattice.degree.u");
  EXPECT_EQ(Count<google::rpc::RetryInfo>(rpc), 0);
  EXPECT_EQ(Count<google::rpc::QuotaFailure>(rpc), 0);
}

TEST(GrpcStatus, MemoryErrorsCarryBytesAskedAndFree) {
  const grpc::Status status = ToGrpcStatus(error::OutOfMemory("the plan", 5'000'000'000, 123));

  EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  const auto rpc = ParseDetails(status);
  const auto info = InfoOf(rpc);
  EXPECT_EQ(info.reason(), "OUT_OF_MEMORY");
  EXPECT_EQ(info.metadata().at("asked_bytes"), "5000000000");
  EXPECT_EQ(info.metadata().at("free_bytes"), "123");
  int count = 0;
  const auto quota = Detail<google::rpc::QuotaFailure>(rpc, count);
  ASSERT_EQ(count, 1);
  EXPECT_THAT(quota.violations(0).description(), HasSubstr("5000000000"));
}

TEST(GrpcStatus, UnavailableCarriesRetryInfo) {
  const auto rpc = ToRpcStatus(error::Unavailable("DRAINING", "shutting down", 2'750));

  int count = 0;
  const auto retry = Detail<google::rpc::RetryInfo>(rpc, count);
  ASSERT_EQ(count, 1);
  EXPECT_EQ(retry.retry_delay().seconds(), 2);
  EXPECT_EQ(retry.retry_delay().nanos(), 750'000'000);
  EXPECT_EQ(InfoOf(rpc).reason(), "DRAINING");
}

TEST(GrpcStatus, EveryCodeOfAbslKeepsItsNumberAndHasAReason) {
  for (int code = 1; code <= 16; ++code) {
    const grpc::Status status =
        ToGrpcStatus(absl::Status(static_cast<absl::StatusCode>(code), "plain"));

    EXPECT_EQ(static_cast<int>(status.error_code()), code);
    const std::string reason = InfoOf(ParseDetails(status)).reason();
    v1::ErrorReason published;
    EXPECT_TRUE(v1::ErrorReason_Parse("ERROR_REASON_" + reason, &published)) << code << reason;
  }
}

TEST(GrpcStatus, NamedErrorsUsePublishedReasons) {
  const absl::Status statuses[] = {error::InvalidField("a", "b"),
                                   error::OutOfRange("a", 1, 2, 3),
                                   error::NotFinite("a"),
                                   error::MalformedFile("OBJ", "line 1", "b"),
                                   error::NotFound("scene", "x"),
                                   error::OutOfMemory("a", 1, 0),
                                   error::AlreadyExists("scene", "x"),
                                   error::Unsupported("a", "b"),
                                   error::Unimplemented("SceneService/Pick")};
  for (const auto& status : statuses) {
    v1::ErrorReason published;
    EXPECT_TRUE(
        v1::ErrorReason_Parse("ERROR_REASON_" + InfoOf(ToRpcStatus(status)).reason(), &published))
        << status;
  }
}

TEST(GrpcStatus, MessagesAreCutAtOneKibibyteBetweenCharacters) {
  std::string message = "a";
  while (message.size() < 5'000) message += "é";  // 2 bytes each; byte 1,024 is inside one

  const grpc::Status status = ToGrpcStatus(absl::InternalError(message));

  EXPECT_EQ(status.error_message().size(), 1'023U);
  EXPECT_EQ(message.substr(0, 1'023), status.error_message());
}

TEST(GrpcStatus, LongDetailsStayBelowTheTrailerLimit) {
  const std::string path(100'000, 'p');
  const auto rpc = ToGrpcStatus(error::WithDetails(
      absl::InvalidArgumentError(path),
      {.reason = "INVALID_FIELD", .field = path, .metadata = {{"a", path}, {"b", "short"}}}));

  EXPECT_LT(rpc.error_message().size() + rpc.error_details().size() * 4 / 3, 8'192U);
}

TEST(GrpcStatus, TheClientGetsBackWhatTheServerMeant) {
  const error::Details sent{.reason = "UNDO_CONFLICT",
                            .field = "edits[0].undo",
                            .metadata = {{"editor_id", "e7"}},
                            .asked_bytes = 10,
                            .free_bytes = 7,
                            .retry_after_ms = 1'234};
  const auto status =
      client::FromGrpc(ToGrpcStatus(error::WithDetails(absl::AbortedError("moved"), sent)));

  const error::Details got = error::DetailsOf(status);
  EXPECT_EQ(status.code(), absl::StatusCode::kAborted);
  EXPECT_EQ(status.message(), "moved");
  EXPECT_EQ(got.reason, sent.reason);
  EXPECT_EQ(got.field, sent.field);
  EXPECT_EQ(got.metadata, sent.metadata);
  EXPECT_EQ(got.asked_bytes, sent.asked_bytes);
  EXPECT_EQ(got.free_bytes, sent.free_bytes);
  EXPECT_EQ(got.retry_after_ms, sent.retry_after_ms);
}

TEST(GrpcStatus, TheClientReadsTheStandardDetailsOfAForeignStatus) {
  google::rpc::Status rpc;
  google::rpc::RetryInfo retry;
  retry.mutable_retry_delay()->set_seconds(2);
  rpc.add_details()->PackFrom(retry);
  google::rpc::BadRequest bad_request;
  bad_request.add_field_violations()->set_field("scene");
  rpc.add_details()->PackFrom(bad_request);
  google::rpc::QuotaFailure quota;
  quota.add_violations()->set_subject("calls");
  quota.mutable_violations(0)->set_description("100 a minute");
  rpc.add_details()->PackFrom(quota);
  const auto status = client::FromGrpc(
      grpc::Status(grpc::StatusCode::RESOURCE_EXHAUSTED, "slow", rpc.SerializeAsString()));

  const error::Details got = error::DetailsOf(status);
  EXPECT_EQ(got.retry_after_ms, 2'000U);
  EXPECT_EQ(got.field, "scene");
  EXPECT_EQ(got.metadata.at("quota"), "calls: 100 a minute");
  EXPECT_FALSE(got.reason.empty());
}

TEST(GrpcStatus, TheClientKeepsCodeAndMessageOfForeignStatuses) {
  const auto status = client::FromGrpc(
      grpc::Status(grpc::StatusCode::UNAVAILABLE, "no route", "\xff not a status"));

  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable);
  EXPECT_EQ(status.message(), "no route");
  EXPECT_EQ(error::DetailsOf(status).reason, "UNAVAILABLE");
}

}  // namespace
}  // namespace latticed
