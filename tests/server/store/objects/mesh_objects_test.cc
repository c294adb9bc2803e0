// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What mesh_objects.h promises, of a folder and of a bucket.
#include "server/store/objects/mesh_objects.h"

#include <filesystem>
#include <memory>
#include <string>

#include "absl/time/time.h"
#include "core/base/sha256.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/store/files/mesh_folder.h"
#include "server/store/objects/s3_meshes.h"
#include "tests/server/store/objects/s3_stub.h"
#include "tests/support/status_matchers.h"
#include "tests/support/temporary_folder.h"

namespace latticed::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

// A place for meshes, and what damages it.
class Place {
 public:
  virtual ~Place() = default;
  virtual MeshObjects& meshes() = 0;
  virtual void Flip(const std::string& id) = 0;
  virtual void Remove(const std::string& id) = 0;
};

class FolderPlace : public Place {
 public:
  MeshObjects& meshes() override { return meshes_; }
  void Flip(const std::string& id) override {
    std::string bytes = folder_.Read("meshes/" + id);
    bytes.back() = static_cast<char>(bytes.back() ^ 1);
    folder_.Write("meshes/" + id, bytes);
  }
  void Remove(const std::string& id) override {
    std::filesystem::remove(folder_.Path("meshes/" + id));
  }

 private:
  TemporaryFolder folder_;
  MeshFolder meshes_{folder_.Path("meshes")};
};

class BucketPlace : public Place {
 public:
  MeshObjects& meshes() override { return meshes_; }
  void Flip(const std::string& id) override { stub_.Execute("flip some/" + id); }
  void Remove(const std::string& id) override { stub_.Execute("remove some/" + id); }

 private:
  S3Stub stub_;
  S3Meshes meshes_{stub_.options()};
};

class MeshObjectsTest : public ::testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if (GetParam() == "folder") place_ = std::make_unique<FolderPlace>();
    if (GetParam() == "s3") place_ = std::make_unique<BucketPlace>();
    ASSERT_OK(meshes().Open({}, absl::ZeroDuration()));
  }
  MeshObjects& meshes() { return place_->meshes(); }
  // Its id.
  std::string Put(const std::string& bytes) {
    const std::string id = Sha256Hex(bytes);
    const absl::StatusOr<std::string> written = meshes().Write(id, bytes);
    EXPECT_OK(written.status());
    EXPECT_OK(meshes().Publish(written.value_or(""), id, bytes));
    return id;
  }

  std::unique_ptr<Place> place_;
};

TEST_P(MeshObjectsTest, KeepsTheMeshesOfTenantsApart) {
  const std::string bytes = "mesh 1", hash = Sha256Hex(bytes);
  for (const std::string& id : {hash, "acme/" + hash, "new-1/" + hash}) {
    const absl::StatusOr<std::string> written = meshes().Write(id, bytes);
    ASSERT_OK(written.status());
    ASSERT_OK(meshes().Publish(*written, id, bytes));
  }
  place_->Flip(hash + ".acme");

  EXPECT_THAT(meshes().Read("acme/" + hash),
              StatusIs(absl::StatusCode::kDataLoss, HasSubstr("another hash")));
  EXPECT_OK(meshes().Remove("acme/" + hash));
  EXPECT_THAT(meshes().Read("acme/" + hash), StatusIs(absl::StatusCode::kDataLoss));
  EXPECT_EQ(meshes().Read(hash).value_or(""), bytes);
  EXPECT_EQ(meshes().Read("new-1/" + hash).value_or(""), bytes);
}

TEST_P(MeshObjectsTest, KeepsBytes) {
  std::string large(9'000'001, '\0');  // more than one part of a transfer, and all bytes
  for (size_t i = 0; i < large.size(); ++i) large[i] = static_cast<char>(i * i / 255);
  for (const std::string& bytes :
       {std::string("mesh 1"), std::string(), std::string("\0\n", 2), large}) {
    const std::string id = Put(bytes);
    ASSERT_OK_AND_ASSIGN(const std::string read, meshes().Read(id));
    EXPECT_TRUE(read == bytes) << read.size() << " of " << bytes.size();
  }
}

TEST_P(MeshObjectsTest, KeepsTheSameBytesOnce) {
  const std::string id = Put("mesh 1");
  EXPECT_EQ(Put("mesh 1"), id);
  EXPECT_OK(meshes().Read(id).status());
}

TEST_P(MeshObjectsTest, PublishesAgain) {
  const std::string id = Sha256Hex("mesh 1");
  ASSERT_OK_AND_ASSIGN(const std::string written, meshes().Write(id, "mesh 1"));
  ASSERT_OK(meshes().Publish(written, id, "mesh 1"));
  EXPECT_OK(meshes().Publish(written, id, "mesh 1"));
  EXPECT_OK(meshes().Read(id).status());

  // Another server removes it. What is published is there: a folder has only one file to publish.
  ASSERT_OK(meshes().Remove(id));
  const absl::Status again = meshes().Publish(written, id, "mesh 1");
  EXPECT_EQ(again.ok(), meshes().Read(id).ok());
  if (!again.ok()) {
    EXPECT_THAT(again, StatusIs(absl::StatusCode::kUnavailable));
  }
}

TEST_P(MeshObjectsTest, RemovesBytesAndWhatIsNotThere) {
  const std::string id = Put("mesh 1");
  const std::string other = Put("mesh 2");
  EXPECT_OK(meshes().Remove(id));
  EXPECT_OK(meshes().Remove(id));
  EXPECT_THAT(meshes().Read(id), StatusIs(absl::StatusCode::kDataLoss, HasSubstr(id)));
  EXPECT_OK(meshes().Read(other).status());
}

TEST_P(MeshObjectsTest, NamesWhatIsDamagedOrMissing) {
  const std::string flipped = Put("mesh 1");
  const std::string missing = Put("mesh 2");
  const std::string sound = Put("mesh 3");
  place_->Flip(flipped);
  place_->Remove(missing);

  EXPECT_THAT(
      meshes().Read(flipped),
      StatusIs(absl::StatusCode::kDataLoss, AllOf(HasSubstr(flipped), HasSubstr("another hash"))));
  EXPECT_THAT(meshes().Read(missing), StatusIs(absl::StatusCode::kDataLoss,
                                               AllOf(HasSubstr(missing), Not(HasSubstr("/")))));
  EXPECT_OK(meshes().Read(sound).status());
  Put("mesh 1");
  EXPECT_OK(meshes().Read(flipped).status()) << "an upload mends it";
}

TEST_P(MeshObjectsTest, WhatIsDiscardedCanBeWrittenAgain) {
  const std::string id = Sha256Hex("mesh 1");
  ASSERT_OK_AND_ASSIGN(const std::string written, meshes().Write(id, "mesh 1"));
  meshes().Discard(written);
  EXPECT_EQ(Put("mesh 1"), id);
  EXPECT_OK(meshes().Read(id).status());
}

INSTANTIATE_TEST_SUITE_P(Places, MeshObjectsTest, ::testing::Values("folder", "s3"),
                         [](const auto& info) { return info.param; });

}  // namespace
}  // namespace latticed::testing
