// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Resumable uploads: unary calls that share an upload id.
#include "server/stores/upload_store.h"

#include "core/base/error.h"
#include "tests/server/support/server_test.h"

namespace latticed::testing {
namespace {

class ResumableUploadTest : public SmallServerTest {
 protected:
  std::string Begin(const std::string& bytes) {
    v1::BeginUploadRequest request;
    *request.mutable_header() = ObjHeader(bytes);
    v1::BeginUploadResponse response;
    EXPECT_OK(Call(&Meshes::BeginUpload, request, &response));
    EXPECT_GT(response.expire_time().seconds(), absl::ToUnixSeconds(absl::Now()) + 3'500);
    return response.upload_id();
  }

  absl::Status Append(const std::string& id, uint64_t offset, const std::string& data,
                      uint64_t* committed = nullptr) {
    v1::AppendUploadRequest request;
    request.set_upload_id(id);
    request.set_offset(offset);
    request.set_data(data);
    v1::AppendUploadResponse response;
    const absl::Status status = Call(&Meshes::AppendUpload, request, &response);
    if (committed != nullptr) *committed = response.committed();
    return status;
  }

  absl::Status Finish(const std::string& id, v1::Mesh* mesh = nullptr) {
    v1::FinishUploadRequest request;
    request.set_upload_id(id);
    return Call(&Meshes::FinishUpload, request, mesh);
  }
};

TEST_F(ResumableUploadTest, PartsBecomeTheMesh) {
  const std::string obj = CubeObj();
  const std::string id = Begin(obj);
  uint64_t committed = 0;
  ASSERT_TRUE(Append(id, 0, obj.substr(0, 20), &committed).ok());
  EXPECT_EQ(committed, 20u);
  // The reply was lost: the client sends the part again, then asks how many bytes the server has.
  ASSERT_TRUE(Append(id, 0, obj.substr(0, 20), &committed).ok());
  EXPECT_EQ(committed, 20u);
  ASSERT_TRUE(Append(id, 0, "", &committed).ok());
  EXPECT_EQ(committed, 20u);
  ASSERT_TRUE(Append(id, 20, obj.substr(20), &committed).ok());
  v1::Mesh mesh;

  ASSERT_OK(Finish(id, &mesh));

  EXPECT_EQ(mesh.faces(), 6u);
  EXPECT_EQ(Reason(Finish(id, &mesh)), "NOT_FOUND");
}

TEST_F(ResumableUploadTest, WrongOffsetsSayWhereToGoOn) {
  const std::string obj = CubeObj();
  const std::string id = Begin(obj);
  ASSERT_TRUE(Append(id, 0, obj.substr(0, 20)).ok());

  for (const uint64_t offset : {uint64_t{19}, uint64_t{21}, ~uint64_t{0}}) {
    const absl::Status status = Append(id, offset, "xyz");

    EXPECT_THAT(status, StatusIs(absl::StatusCode::kFailedPrecondition)) << offset;
    EXPECT_EQ(Reason(status), "OFFSET_MISMATCH");
    EXPECT_NE(status.message().find("20 bytes"), std::string::npos);
  }
}

TEST_F(ResumableUploadTest, MissingBytesLeaveTheUpload) {
  const std::string obj = CubeObj();
  const std::string id = Begin(obj);

  EXPECT_EQ(Reason(Finish(id)), "SIZE_MISMATCH");
  EXPECT_TRUE(Append(id, 0, obj).ok());
  EXPECT_OK(Finish(id));
}

TEST_F(ResumableUploadTest, MoreThanAnnouncedIsRefused) {
  const std::string id = Begin(CubeObj());

  const absl::Status status = Append(id, 0, CubeObj() + "\n");

  EXPECT_THAT(status, StatusIs(absl::StatusCode::kInvalidArgument));
  EXPECT_EQ(Reason(status), "SIZE_MISMATCH");
}

TEST_F(ResumableUploadTest, UnknownUploadIsNotFound) {
  EXPECT_EQ(Reason(Append("none", 0, "x")), "NOT_FOUND");
  EXPECT_EQ(Reason(Finish("none")), "NOT_FOUND");
}

// A caller without a share of his own.
const CallerAccount& Anyone() {
  static const CallerAccount anyone(1, {});
  return anyone;
}

TEST(UploadStoreTest, IdleUploadsExpireAndGiveTheirBytesBack) {
  absl::Time now = absl::UnixEpoch();
  const auto memory = std::make_shared<MemoryBudget>(1'000);
  UploadStore uploads(memory, [&now] { return now; });
  const UploadHeader header{.total_bytes = 900};
  auto upload = uploads.Admit(header, Anyone());
  ASSERT_OK(upload);
  EXPECT_EQ(memory->used_bytes(), 0u) << "only announced";
  ASSERT_OK((*upload)->Append(std::string(900, 'x')));
  const std::string id = uploads.Keep(*std::move(upload));
  upload = absl::UnknownError("moved away");

  now += absl::Minutes(59);
  EXPECT_OK(uploads.Find(id));  // each use extends the time
  now += absl::Minutes(59);
  EXPECT_OK(uploads.Find(id));
  EXPECT_EQ(memory->used_bytes(), 900u);
  const auto other = uploads.Admit(header, Anyone());
  ASSERT_OK(other);
  EXPECT_THAT((*other)->Append(std::string(900, 'x')),
              StatusIs(absl::StatusCode::kResourceExhausted));
  now += absl::Minutes(60);

  EXPECT_THAT(uploads.Find(id), StatusIs(absl::StatusCode::kNotFound));
  EXPECT_EQ(memory->used_bytes(), 0u);
}

TEST(UploadStoreTest, UploadsAtATimeAreLimited) {
  const auto memory = std::make_shared<MemoryBudget>(1'000'000);
  UploadStore uploads(memory);
  const UploadHeader header{.total_bytes = 1};
  std::vector<std::shared_ptr<Upload>> held;
  for (int i = 0; i < 64; ++i) {
    auto upload = uploads.Admit(header, Anyone());
    ASSERT_OK(upload);
    held.push_back(*std::move(upload));
  }

  const auto refused = uploads.Admit(header, Anyone());
  EXPECT_THAT(refused, StatusIs(absl::StatusCode::kResourceExhausted));
  EXPECT_EQ(error::DetailsOf(refused.status()).reason, "LIMIT_EXCEEDED");
  held.pop_back();
  EXPECT_OK(uploads.Admit(header, Anyone()));
}

TEST(UploadStoreTest, AStreamThatFallsSilentLosesItsPlace) {
  absl::Time now = absl::UnixEpoch();
  const auto memory = std::make_shared<MemoryBudget>(100'000);
  UploadStore uploads(memory, [&now] { return now; });
  const UploadHeader header{.total_bytes = 900};
  std::vector<std::shared_ptr<Upload>> streams;
  for (int i = 0; i < 64; ++i) {
    auto upload = uploads.Admit(header, Anyone());
    ASSERT_OK(upload);
    streams.push_back(*std::move(upload));
  }
  now += absl::Minutes(30);
  EXPECT_OK(streams[0]->Append("v 0 0 0\n"));
  now += absl::Minutes(30);

  EXPECT_OK(uploads.Admit(header, Anyone())) << "63 places are free";
  EXPECT_EQ(memory->used_bytes(), 8u) << "of the one that got bytes";
  EXPECT_OK(streams[0]->Append("v 1 0 0\n"));
  EXPECT_THAT(streams[1]->Append("v 0 0 0\n"), StatusIs(absl::StatusCode::kNotFound));
  EXPECT_THAT(streams[1]->CheckComplete(), StatusIs(absl::StatusCode::kNotFound));
}

TEST(UploadStoreTest, AnExpiredUploadGivesItsMemoryBackWithoutAnotherCall) {
  absl::Time now = absl::Now();
  const auto memory = std::make_shared<MemoryBudget>(1'000'000);
  UploadStore uploads(memory, [&now] { return now; });
  auto upload = uploads.Admit({.total_bytes = CubeObj().size()}, Anyone());
  ASSERT_OK(upload);
  ASSERT_OK((*upload)->Append(CubeObj()));
  const std::string id = uploads.Keep(*std::move(upload));
  upload = absl::CancelledError("let go");
  ASSERT_EQ(memory->used_bytes(), CubeObj().size());

  now += absl::Minutes(59);
  uploads.DropExpired();
  EXPECT_EQ(memory->used_bytes(), CubeObj().size());
  now += absl::Minutes(2);
  uploads.DropExpired();

  EXPECT_EQ(memory->used_bytes(), 0u);
  EXPECT_THAT(uploads.Find(id), StatusIs(absl::StatusCode::kNotFound));
}

}  // namespace
}  // namespace latticed::testing
