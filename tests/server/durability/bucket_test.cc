// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Daemons over one PostgreSQL and one bucket of meshes, and how they refuse to start without the bucket.
#include <cstdlib>
#include <string>
#include <vector>

#include "fmt/format.h"
#include "tests/server/durability/shared_scene_test.h"
#include "tests/server/store/objects/s3_stub.h"

namespace latticed::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class BucketTest : public StreamTest {
 protected:
  void SetUp() override {
    if (!PostgresServer::IsInstalled()) {
      ASSERT_EQ(std::getenv("LATTICED_REQUIRE_POSTGRES"), nullptr) << "PostgreSQL is not installed";
      GTEST_SKIP() << "PostgreSQL is not installed: no bucket was tested with it";
    }
    url_file_ = folder_.Write("url", PostgresServer::Shared().NewDatabase());
    setenv("AWS_ACCESS_KEY_ID", "AKIDEXAMPLE", 1);
    setenv("AWS_SECRET_ACCESS_KEY", S3Stub::kSecret, 1);
  }
  std::vector<std::string> Arguments(const std::string& name, const std::string& bucket,
                                     const std::string& endpoint) const {
    auto arguments = SharingArguments(url_file_, bucket, name);
    arguments.insert(arguments.end(), {"--s3-endpoint", endpoint});
    return arguments;
  }
  // The last line of a daemon that does not start.
  std::string RefusalOfStart(const std::string& bucket, const std::string& endpoint) {
    Daemon daemon(Arguments("c", bucket, endpoint));
    std::string all, line, last;
    while (!(line = daemon.ReadLine()).empty()) all += last = line;
    EXPECT_EQ(daemon.Wait(), 1);
    EXPECT_THAT(all, Not(HasSubstr("secret")));
    return last;
  }

  TemporaryFolder folder_;
  std::string url_file_;
  S3Stub stub_;
};

TEST_F(BucketTest, AnotherServerFindsTheMeshOfAScene) {
  Daemon first(Arguments("a", "s3://meshes/of-all", stub_.endpoint()));
  Reach(grpc::CreateChannel(first.Address(), grpc::InsecureChannelCredentials()));
  ASSERT_NO_FATAL_FAILURE(CreateScene());
  EXPECT_THAT(stub_.Execute("keys"), HasSubstr("of-all/"));
  first.Signal(SIGTERM);

  Daemon second(Arguments("b", "s3://meshes/of-all", stub_.endpoint()));
  Reach(grpc::CreateChannel(second.Address(), grpc::InsecureChannelCredentials()));
  absl::Status applied = Apply(Move(1, 62, 0.1));
  const absl::Time end = absl::Now() + absl::Minutes(1);
  while (Reason(applied) == "SCENE_MOVED" && absl::Now() < end) {
    absl::SleepFor(absl::Milliseconds(5));
    applied = Apply(Move(1, 62, 0.1));
  }
  EXPECT_OK(applied);
  EXPECT_EQ(first.Wait(), 0);
  second.Signal(SIGKILL);
  (void)second.Wait();
}

TEST_F(BucketTest, AStartWithoutTheBucketIsRefusedInASentence) {
  const std::string place =
      fmt::format("latticed: s3://meshes/ at {}: the store fails: S3", stub_.endpoint());
  EXPECT_EQ(
      RefusalOfStart("s3://none", stub_.endpoint()),
      fmt::format("latticed: s3://none/ at {}: the store fails: S3 answers 404 NoSuchBucket\n",
                  stub_.endpoint()));
  setenv("AWS_SECRET_ACCESS_KEY", "another-secret", 1);
  EXPECT_EQ(RefusalOfStart("s3://meshes", stub_.endpoint()),
            place + " answers 403 SignatureDoesNotMatch\n");
  EXPECT_EQ(RefusalOfStart("s3://meshes", "http://127.0.0.1:1"),
            "latticed: s3://meshes/ at http://127.0.0.1:1: the store fails: S3: Couldn't connect "
            "to server\n");
  EXPECT_EQ(RefusalOfStart("s3://meshes", "http://ann:secret@host"),
            "latticed: the endpoint of the bucket is not https://host:port\n");
  unsetenv("AWS_SECRET_ACCESS_KEY");
  EXPECT_EQ(RefusalOfStart("s3://meshes", stub_.endpoint()),
            "latticed: 's3://meshes' needs AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY in the "
            "environment, or a file of keys in AWS_SHARED_CREDENTIALS_FILE\n");
}

}  // namespace
}  // namespace latticed::testing
