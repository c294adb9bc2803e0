// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How a view divides Encode among its parts. tests/backend/spanned_test.cc shows that the bytes are
// those of one device.
#include "core/view/spanned/spanned_view.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <numeric>
#include <thread>
#include <utility>

#include "core/base/error.h"
#include "tests/backend/conformance.h"
#include "tests/support/status_matchers.h"
#include "tests/support/test_meshes.h"

namespace latticed::testing {
namespace {

using Chunks = std::vector<uint32_t>;

// Counts the parts that have called Encode. Each waits there for `wanted` parts, for a minute at most.
struct Meeting {
  std::atomic<int> came = 0;
  int wanted = 1;
  bool Wait() {
    ++came;
    const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(1);
    while (came < wanted && std::chrono::steady_clock::now() < end) std::this_thread::yield();
    return came >= wanted;
  }
};

// Encodes each chunk, in the part's own numbers, as that number plus `name`.
class PartView : public DeformView {
 public:
  PartView(Meeting& meeting, uint8_t name) : meeting_(meeting), name_(name) {}

  const ViewSpec& spec() const override { return spec_; }
  absl::Status Evaluate(std::span<const Vec3d>, const QuantisationBox&,
                        std::span<const uint32_t>) override {
    return absl::OkStatus();
  }
  absl::Status Read(uint32_t, std::span<uint8_t>) override { return absl::OkStatus(); }
  absl::StatusOr<std::vector<SharedBytes>> Encode(std::span<const uint32_t> chunks, Encoding,
                                                  std::span<VertexDigest> digests,
                                                  TakeEarly) override {
    if (!meeting_.Wait()) return absl::DeadlineExceededError("the other part never came");
    if (fails_) throw std::bad_alloc();
    std::vector<SharedBytes> results;
    for (const uint32_t chunk : chunks) {
      results.push_back(MakeSharedBytes({static_cast<uint8_t>(name_ + chunk)}));
    }
    for (VertexDigest& digest : digests) digest = {name_, digest.low};
    return results;
  }
  MemoryUse memory() const override { return {}; }

  void Fail() { fails_ = true; }

 private:
  const ViewSpec spec_;
  Meeting& meeting_;
  const uint8_t name_;
  bool fails_ = false;
};

class SpannedViewTest : public ::testing::Test {
 protected:
  // At least twelve chunks. The first part has chunks 0 to 5.
  void SetUp() override {
    PolygonMesh mesh = TorusMesh(24, 20);
    const LatticeStructure structure = MakeStructure(mesh.ComputeBounds(), {});
    plan_ = MakeTestPlan(std::move(mesh), structure);
    ASSERT_GE(plan_->chunk_count(), 12u);
    auto first = std::make_unique<PartView>(meeting_, 100);
    auto second = std::make_unique<PartView>(meeting_, 200);
    second_ = second.get();
    std::vector<SpannedView::Part> parts;
    parts.push_back({0, std::move(first)});
    parts.push_back({6, std::move(second)});
    view_ = std::make_unique<SpannedView>(plan_, ViewSpec{}, std::move(parts));
    Chunks all(plan_->chunk_count());
    std::iota(all.begin(), all.end(), 0u);
    ASSERT_OK(view_->Evaluate(plan_->identity_points, BoxFor(*plan_, plan_->identity_points), all));
  }

  Plan plan_;
  Meeting meeting_;
  PartView* second_ = nullptr;
  std::unique_ptr<SpannedView> view_;
};

TEST(EncodeOrder, EachCallHasWorkForEveryDevice) {
  const ViewTraits traits{.encode_batch = 4, .device_chunks = {0, 6}};
  EXPECT_EQ(EncodeOrder(traits, Chunks{0, 1, 2, 4, 5, 6, 8, 9, 10}),
            (Chunks{0, 1, 6, 8, 2, 4, 9, 10, 5}));
  EXPECT_EQ(EncodeOrder(traits, Chunks{7, 8, 9}), (Chunks{7, 8, 9}));
  EXPECT_EQ(EncodeOrder(traits, Chunks{}), Chunks{});
  EXPECT_EQ(EncodeOrder({}, Chunks{2, 7, 9}), (Chunks{2, 7, 9}));
}

TEST_F(SpannedViewTest, PartsEncodeAtOnceAndEachResultFindsItsPlace) {
  meeting_.wanted = 2;
  std::vector<VertexDigest> digests{{1, 0}, {2, 0}, {3, 0}, {4, 0}};

  ASSERT_OK_AND_ASSIGN(const auto encoded,
                       view_->Encode(Chunks{7, 0, 6, 5}, Encoding::kQuantised, digests));
  std::vector<int> bytes;
  for (const SharedBytes& result : encoded) bytes.push_back(result.span()[0]);
  EXPECT_EQ(bytes, (std::vector<int>{201, 100, 200, 105}));
  EXPECT_EQ(digests, (std::vector<VertexDigest>{{200, 1}, {100, 2}, {200, 3}, {100, 4}}));
}

TEST_F(SpannedViewTest, APartThatIsShortOfMemoryRefusesForAll) {
  second_->Fail();
  const auto refused = view_->Encode(Chunks{0, 7}, Encoding::kQuantised, {});
  EXPECT_THAT(refused, StatusIs(absl::StatusCode::kResourceExhausted));
  EXPECT_OK(view_->Encode(Chunks{0}, Encoding::kQuantised, {}));
}

}  // namespace
}  // namespace latticed::testing
