// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The store in PostgreSQL with its meshes in a bucket.
#include <cstdlib>

#include "core/base/sha256.h"
#include "tests/server/store/objects/s3_stub.h"
#include "tests/server/store/postgres/postgres_store.h"

namespace latticed::testing {
namespace {

using ::testing::HasSubstr;

class PostgresBucket : public PostgresStore {
 protected:
  void SetUp() override {
    PostgresStore::SetUp();
    setenv("AWS_ACCESS_KEY_ID", "AKIDEXAMPLE", 1);
    setenv("AWS_SECRET_ACCESS_KEY", S3Stub::kSecret, 1);
  }
  absl::StatusOr<std::unique_ptr<Store>> OpenWith(const std::string& bucket) {
    return OpenPostgresStore({.url_file = folder_.Write("url", url_),
                              .mesh_store = bucket,
                              .s3_endpoint = stub_.endpoint(),
                              .s3_region = "us-east-1",
                              .name = "host-1:50051"});
  }

  S3Stub stub_;
  const std::string id_ = Sha256Hex("mesh 1");
};

TEST_F(PostgresBucket, MeshesAreOfAllServers) {
  ASSERT_OK_AND_ASSIGN(const auto first, OpenWith("s3://meshes"));
  ASSERT_OK(first->PutMesh(id_, "header", "mesh 1"));
  ASSERT_OK_AND_ASSIGN(const auto second, OpenWith("s3://meshes"));

  ASSERT_OK_AND_ASSIGN(const std::string bytes, second->ReadMesh(id_));
  EXPECT_EQ(bytes, "mesh 1");
  EXPECT_EQ(stub_.Execute("keys"), id_ + " latticed-probe");
  ASSERT_OK(second->DeleteMesh(id_));
  EXPECT_EQ(stub_.Execute("keys"), "latticed-probe");
  EXPECT_THAT(first->ReadMesh(id_), StatusIs(absl::StatusCode::kNotFound));
}

TEST_F(PostgresBucket, ADamagedMeshIsNamedAndMended) {
  ASSERT_OK_AND_ASSIGN(const auto store, OpenWith("s3://meshes"));
  ASSERT_OK(store->PutMesh(id_, "header", "mesh 1"));
  stub_.Execute("flip " + id_);

  EXPECT_THAT(store->ReadMesh(id_), StatusIs(absl::StatusCode::kDataLoss, HasSubstr(id_)));
  EXPECT_OK(OpenWith("s3://meshes").status()) << "a start does not read meshes";
  ASSERT_OK(store->PutMesh(id_, "header", "mesh 1"));
  EXPECT_OK(store->ReadMesh(id_).status());
}

TEST_F(PostgresBucket, AMeshThatCannotBeStoredHasNoRow) {
  ASSERT_OK_AND_ASSIGN(const auto store, OpenWith("s3://meshes"));
  stub_.Execute("fail 1 507 XMinioStorageFull");

  EXPECT_THAT(store->PutMesh(id_, "header", "mesh 1"),
              StatusIs(absl::StatusCode::kResourceExhausted, HasSubstr("507")));
  EXPECT_THAT(store->ReadMeshHeader(id_), StatusIs(absl::StatusCode::kNotFound));
  ASSERT_OK(store->CreateScene("gear", ""));
  EXPECT_OK(AppendTo(*store, "gear", 1, "x")) << "edits need no bucket";
  EXPECT_OK(store->PutMesh(id_, "header", "mesh 1"));
}

TEST_F(PostgresBucket, AMeshWhoseDeletionFailsIsGone) {
  ASSERT_OK_AND_ASSIGN(const auto store, OpenWith("s3://meshes"));
  ASSERT_OK(store->PutMesh(id_, "header", "mesh 1"));
  stub_.Execute("fail 1 403 AccessDenied");

  EXPECT_OK(store->DeleteMesh(id_));
  EXPECT_THAT(store->ReadMesh(id_), StatusIs(absl::StatusCode::kNotFound));
  EXPECT_EQ(stub_.Execute("keys"), id_ + " latticed-probe") << "it costs its space";
}

TEST_F(PostgresBucket, AnUnusableBucketIsRefused) {
  EXPECT_THAT(OpenWith("s3://other").status(),
              StatusIs(absl::StatusCode::kUnavailable, HasSubstr("404 NoSuchBucket")));
  EXPECT_THAT(OpenWith("s3://").status(),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("is no bucket")));
}

}  // namespace
}  // namespace latticed::testing
