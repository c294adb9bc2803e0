// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The machine runs out of memory in the middle of a request. The request is refused, and the server goes
// on.
#include <algorithm>
#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <new>

#include <gtest/gtest.h>

#include "tests/server/support/server_test.h"

namespace {
// Allocations of more bytes than this fail.
std::atomic<size_t> largest_allocation = SIZE_MAX;

void* Allocate(size_t bytes) {
  void* memory = bytes > largest_allocation ? nullptr : std::malloc(bytes);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}
}  // namespace

void* operator new(size_t bytes) { return Allocate(bytes); }
void* operator new[](size_t bytes) { return Allocate(bytes); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, size_t) noexcept { std::free(memory); }

namespace latticed::testing {
namespace {

constexpr size_t kScarce = 150'000;

class OutOfMemoryTest : public SceneFixture {
 protected:
  void TearDown() override { largest_allocation = SIZE_MAX; }
  static void ExpectExhausted(const absl::Status& status) {
    ExpectRefused(status, absl::StatusCode::kResourceExhausted, "OUT_OF_MEMORY");
  }
};

TEST_F(OutOfMemoryTest, APlanIsRefusedAndTheServerGoesOn) {
  mesh_ = Upload(PlaneObj(60));

  largest_allocation = kScarce;
  ExpectExhausted(Create(SceneRequest()));
  largest_allocation = SIZE_MAX;

  EXPECT_OK(Create(SceneRequest()));
}

TEST_F(OutOfMemoryTest, AnInsertedKnotIsRefusedAndNothingChanged) {
  mesh_ = Upload(PlaneObj(60));
  ASSERT_OK(Create(SceneRequest()));
  v1::EditBatch batch = Knot("alice", 1);

  largest_allocation = kScarce;
  ExpectExhausted(Apply(batch));
  largest_allocation = SIZE_MAX;

  const v1::LatticeState state = Lattice();
  EXPECT_EQ(state.revision(), 0u);
  EXPECT_EQ(state.structure_id(), 1u);
  batch.set_sequence(2);
  EXPECT_OK(Apply(batch));
}

TEST_F(OutOfMemoryTest, AnUploadIsRefused) {
  const std::string obj = PlaneObj(100);
  constexpr size_t kPart = 40'000;
  grpc::ClientContext context;
  v1::Mesh mesh;
  const auto writer = meshes_->UploadMesh(&context, &mesh);
  v1::UploadMeshRequest request;
  *request.mutable_header() = ObjHeader(obj);
  writer->Write(request);
  writer->WaitForInitialMetadata();
  largest_allocation = kScarce;
  for (size_t at = 0; at < obj.size(); at += kPart) {
    request.set_data(obj.data() + at, std::min(kPart, obj.size() - at));
    if (!writer->Write(request)) break;
  }
  writer->WritesDone();
  const absl::Status status = client::FromGrpc(writer->Finish());
  largest_allocation = SIZE_MAX;

  ExpectExhausted(status);
  EXPECT_FALSE(Upload(obj).empty());
}

TEST_F(OutOfMemoryTest, AnExportAndAnUpdateAreRefused) {
  mesh_ = Upload(PlaneObj(60));
  ASSERT_OK(Create(SceneRequest()));
  auto request = For<v1::ExportRequest>();
  request.set_format(v1::EXPORT_FORMAT_OBJ);
  auto update = For<v1::GetUpdateRequest>();
  update.mutable_view()->set_segments(32);
  for (const bool scarce : {true, false}) {
    largest_allocation = scarce ? kScarce : SIZE_MAX;
    const absl::Status exported = ReadAll(&Scenes::Export, request);
    const absl::Status updated = ReadAll(&Scenes::GetUpdate, update);
    largest_allocation = SIZE_MAX;
    if (scarce) {
      ExpectExhausted(exported);
    } else {
      EXPECT_OK(exported);
      EXPECT_OK(updated);
    }
  }
}

}  // namespace
}  // namespace latticed::testing
