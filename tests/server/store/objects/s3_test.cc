// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What a bucket alone has: its URL, its refusals, and a server that does not answer.
#include <cstdlib>
#include <string>

#include "absl/time/clock.h"
#include "core/base/error.h"
#include "core/base/sha256.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/store/objects/s3_client.h"
#include "server/store/objects/s3_meshes.h"
#include "server/store/objects/s3_options.h"
#include "tests/server/store/objects/s3_stub.h"
#include "tests/support/status_matchers.h"
#include "tests/support/temporary_folder.h"

namespace latticed::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class S3Test : public ::testing::Test {
 protected:
  static absl::Status Open(const S3Options& options) {
    return S3Meshes(options).Open({}, absl::ZeroDuration());
  }
  absl::Status Put(S3Client& client, const std::string& bytes) {
    return client.Put(Sha256Hex(bytes), bytes, Sha256Hex(bytes));
  }
  std::string Requests() { return stub_.Execute("requests"); }

  S3Stub stub_;
};

TEST_F(S3Test, ReadsUrlsAndTheEnvironment) {
  setenv("AWS_ACCESS_KEY_ID", "AKIDEXAMPLE", 1);
  setenv("AWS_SECRET_ACCESS_KEY", S3Stub::kSecret, 1);
  ASSERT_OK_AND_ASSIGN(S3Options options, S3OptionsOf("s3://meshes/a/b", "", "eu-west-3"));
  EXPECT_EQ(options.bucket, "meshes");
  EXPECT_EQ(options.prefix, "a/b/");
  EXPECT_EQ(options.endpoint, "https://s3.eu-west-3.amazonaws.com");
  EXPECT_EQ(options.access_key, "AKIDEXAMPLE");
  EXPECT_EQ(options.secret_key, S3Stub::kSecret);
  EXPECT_EQ(options.session_token, "");
  setenv("AWS_SESSION_TOKEN", "token", 1);
  ASSERT_OK_AND_ASSIGN(options, S3OptionsOf("s3://meshes", "http://[::1]:9000", "eu-west-3"));
  EXPECT_EQ(options.prefix, "");
  EXPECT_EQ(options.session_token, "token");
  unsetenv("AWS_SESSION_TOKEN");

  const auto refused = [](const std::string& url, const std::string& endpoint,
                          const std::string& region, const std::string& problem) {
    EXPECT_THAT(S3OptionsOf(url, endpoint, region).status(),
                StatusIs(absl::StatusCode::kInvalidArgument,
                         AllOf(HasSubstr(problem), Not(HasSubstr("secret")))))
        << url << endpoint << region;
  };
  for (const std::string url :
       {"s3://", "s3:///a", "s3://a/../b", "s3://a//b", "s3://a/b?c", "s3://a b", "folder"}) {
    refused(url, "", "us-east-1", "is no bucket");
  }
  for (const std::string endpoint :
       {"minio:9000", "http://", "https://ann:secret@host", "http://host/path", "ftp://host"}) {
    refused("s3://meshes", endpoint, "us-east-1", "endpoint");
  }
  refused("s3://meshes", "", "us east", "region");
  setenv("AWS_SECRET_ACCESS_KEY", "secret\r\nhost: other", 1);
  refused("s3://meshes", "", "us-east-1", "characters");
  unsetenv("AWS_SECRET_ACCESS_KEY");
  refused("s3://meshes", "", "us-east-1", "needs AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY");
}

TEST_F(S3Test, SaysWhyABucketCannotBeUsed) {
  EXPECT_OK(Open(stub_.options()));
  EXPECT_EQ(stub_.Execute("keys"), "some/latticed-probe");

  const std::string place = "s3://meshes/some/ at " + stub_.endpoint() + ": the store fails: S3";
  S3Options options = stub_.options();
  options.secret_key = "another secret";
  EXPECT_THAT(Open(options), StatusIs(absl::StatusCode::kUnavailable,
                                      place + " answers 403 SignatureDoesNotMatch"));
  options = stub_.options();
  options.access_key = "AKIDOTHER";
  EXPECT_THAT(Open(options),
              StatusIs(absl::StatusCode::kUnavailable, place + " answers 403 InvalidAccessKeyId"));
  options = stub_.options();
  options.region = "eu-west-3";
  EXPECT_THAT(Open(options), StatusIs(absl::StatusCode::kUnavailable,
                                      place + " answers 400 AuthorizationHeaderMalformed"));
  options = stub_.options();
  options.bucket = "other";
  EXPECT_THAT(Open(options),
              StatusIs(absl::StatusCode::kUnavailable, HasSubstr("S3 answers 404 NoSuchBucket")));
  options = stub_.options();
  options.endpoint = "http://127.0.0.1:1";
  EXPECT_THAT(Open(options), StatusIs(absl::StatusCode::kUnavailable,
                                      AllOf(HasSubstr("127.0.0.1:1"), HasSubstr("connect"))));
}

TEST_F(S3Test, ASessionTokenIsSigned) {
  S3Stub stub("IQoJb3JpZ2luX2VjEXAMPLE//+=");
  S3Options options = stub.options();
  EXPECT_THAT(Open(options), StatusIs(absl::StatusCode::kUnavailable, HasSubstr("InvalidToken")));
  options.session_token = "IQoJb3JpZ2luX2VjEXAMPLE//+=";
  EXPECT_OK(Open(options));
}

TEST_F(S3Test, KeysOfAFileAreReadAgain) {
  const TemporaryFolder folder;
  const auto write = [&](const std::string& secret, const std::string& token) {
    return folder.Write("keys",
                        "# of today\n[other]\naws_access_key_id = AKIDOTHER\n[default]\n"
                        "aws_access_key_id=AKIDEXAMPLE\naws_secret_access_key = " +
                            secret + "\r\naws_session_token = " + token + "\n");
  };
  unsetenv("AWS_ACCESS_KEY_ID");
  setenv("AWS_SHARED_CREDENTIALS_FILE", write(S3Stub::kSecret, "old").c_str(), 1);
  S3Stub stub("new-token");
  ASSERT_OK_AND_ASSIGN(S3Options options,
                       S3OptionsOf("s3://meshes/some", stub.endpoint(), "us-east-1"));
  S3Client client(options);
  EXPECT_THAT(Put(client, "mesh 1"), StatusIs(absl::StatusCode::kUnavailable, HasSubstr("Token")));
  write(S3Stub::kSecret, "new-token");
  EXPECT_OK(Put(client, "mesh 1"));

  for (const std::string rubbish : {"", "[default]\naws_access_key_id = AKID\n"}) {
    folder.Write("keys", rubbish);
    EXPECT_OK(Put(client, "mesh 1")) << "the keys stay";
    EXPECT_THAT(ReadS3Keys(options),
                StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("keys: section [default]")));
  }
  write("secret key", "");
  EXPECT_THAT(S3OptionsOf("s3://meshes", "", "us-east-1").status(),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr("characters"), Not(HasSubstr("secret key")))));
  setenv("AWS_SHARED_CREDENTIALS_FILE", folder.Path("none").c_str(), 1);
  EXPECT_THAT(S3OptionsOf("s3://meshes", "", "us-east-1").status(),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr("none")));
  unsetenv("AWS_SHARED_CREDENTIALS_FILE");
}

TEST_F(S3Test, BytesThatChangeOnTheirWayAreRefused) {
  S3Client client(stub_.options());
  EXPECT_THAT(client.Put("key", "mesh 1", Sha256Hex("mesh 2")),
              StatusIs(absl::StatusCode::kUnavailable, HasSubstr("XAmzContentSHA256Mismatch")));
  EXPECT_EQ(stub_.Execute("keys"), "");
}

TEST_F(S3Test, TriesAgainWhatMayPass) {
  S3Client client(stub_.options());
  for (const std::string fault : {"fail 8 503 SlowDown", "fail 1 500 InternalError", "drop 2"}) {
    stub_.Execute(fault);
    EXPECT_OK(Put(client, "mesh 1")) << fault;
  }
  stub_.Execute("cut 1");
  ASSERT_OK_AND_ASSIGN(const std::string bytes, client.Get(Sha256Hex("mesh 1")));
  EXPECT_EQ(bytes, "mesh 1");
}

TEST_F(S3Test, GivesUpAfterSomeTime) {
  S3Options options = stub_.options();
  options.most_time = absl::Seconds(1);
  S3Client client(options);
  stub_.Execute("fail 1000 503 SlowDown");
  const absl::Status refused = Put(client, "mesh 1");

  EXPECT_THAT(refused,
              StatusIs(absl::StatusCode::kUnavailable, "the store fails: S3 answers 503 SlowDown"));
  EXPECT_EQ(error::DetailsOf(refused).reason, "STORE");
  EXPECT_GT(error::DetailsOf(refused).retry_after_ms, 0U);
  EXPECT_GT(std::stoi(Requests()), 2);
}

TEST_F(S3Test, DoesNotTryAgainWhatStays) {
  S3Client client(stub_.options());
  for (const std::string fault :
       {"507 XMinioStorageFull", "403 QuotaExceeded", "413 EntityTooLarge"}) {
    stub_.Execute("fail 1 " + fault);
    EXPECT_THAT(Put(client, "mesh 1"),
                StatusIs(absl::StatusCode::kResourceExhausted, HasSubstr(fault)));
  }
  stub_.Execute("fail 1 403 AccessDenied");
  EXPECT_THAT(Put(client, "mesh 1"), StatusIs(absl::StatusCode::kUnavailable, HasSubstr("403")));
  EXPECT_EQ(Requests(), "4");
  EXPECT_THAT(client.Get("none"), StatusIs(absl::StatusCode::kNotFound));
  EXPECT_THAT(client.Head("none"), StatusIs(absl::StatusCode::kNotFound));
  EXPECT_OK(client.Delete("none"));
  EXPECT_EQ(Requests(), "7");
}

TEST_F(S3Test, AServerThatStandsStillIsLeft) {
  EXPECT_LT(S3Options().patience, S3Options().most_time) << "else it is not tried again";
  S3Client client(stub_.options());
  stub_.Execute("stall 1");
  EXPECT_OK(Put(client, "mesh 1"));
  EXPECT_EQ(Requests(), "2");
  stub_.Execute("stall 100");
  EXPECT_THAT(
      client.Get(Sha256Hex("mesh 1")).status(),
      StatusIs(absl::StatusCode::kUnavailable, "the store fails: S3: it stood still for 1s"));
}

// Another server has deleted the same mesh between Write and Publish.
TEST_F(S3Test, WhatIsGoneIsPublishedAgain) {
  S3Meshes meshes(stub_.options());
  const std::string id = Sha256Hex("mesh 1");
  ASSERT_OK_AND_ASSIGN(const std::string written, meshes.Write(id, "mesh 1"));
  ASSERT_OK(meshes.Remove(id));
  ASSERT_OK(meshes.Publish(written, id, "mesh 1"));
  EXPECT_OK(meshes.Read(id).status());
}

}  // namespace
}  // namespace latticed::testing
