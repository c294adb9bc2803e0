// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What slices get from each other, and what follows where one of them fails. tests/backend/tolerance_bits_test.cc shows
// that the bits are those of one device.
#include "core/view/spanned/tolerance_exchange.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "tests/backend/conformance.h"

namespace latticed::testing {
namespace {

constexpr float kNotANumber = std::numeric_limits<float>::quiet_NaN();

enum class SliceStep { kNone, kReach, kShare, kBound, kSharedBounds, kChoose, kCount, kFinish };

// A slice with given bounds, whose points become fewer as the tolerance grows.
class FakeSlice : public DeformView, public ToleranceSlice {
 public:
  const ViewSpec& spec() const override { return spec_; }
  absl::Status Evaluate(std::span<const Vec3d>, const QuantisationBox&,
                        std::span<const uint32_t>) override {
    return absl::InternalError("a slice is evaluated in steps");
  }
  absl::Status Read(uint32_t, std::span<uint8_t>) override { return absl::OkStatus(); }
  absl::StatusOr<std::vector<SharedBytes>> Encode(std::span<const uint32_t>, Encoding,
                                                  std::span<VertexDigest>, TakeEarly) override {
    return std::vector<SharedBytes>();
  }
  MemoryUse memory() const override { return {}; }
  ToleranceSlice* tolerance_slice() override { return this; }

  absl::StatusOr<std::vector<Vec3d>> BoxReach() override {
    if (auto s = Pass(SliceStep::kReach); !s.ok()) return s;
    return reach;
  }
  absl::Status SetReach(std::span<const Vec3d> r) override {
    reach.assign(r.begin(), r.end());
    return absl::OkStatus();
  }
  absl::Status ShareEdges(std::span<const uint32_t> e) override {
    edges.assign(e.begin(), e.end());
    bounds.resize(edges.size());
    return Pass(SliceStep::kShare);
  }
  absl::Status Bound(std::span<const Vec3d>, const QuantisationBox&,
                     std::span<const uint32_t> c) override {
    chunks.assign(c.begin(), c.end());
    return Pass(SliceStep::kBound);
  }
  absl::StatusOr<std::span<const float>> SharedBounds() override {
    if (auto s = Pass(SliceStep::kSharedBounds); !s.ok()) return s;
    return std::span<const float>(bounds);
  }
  absl::Status Choose(double tolerance, std::span<const float> b) override {
    tolerances.push_back(tolerance);
    raised.assign(b.begin(), b.end());
    return Pass(SliceStep::kChoose);
  }
  absl::StatusOr<uint64_t> CountPoints() override {
    if (auto s = Pass(SliceStep::kCount); !s.ok()) return s;
    return static_cast<uint64_t>(points_at_one / tolerances.back());
  }
  absl::Status Finish() override {
    ++finished;
    return Pass(SliceStep::kFinish);
  }

  SliceStep fails = SliceStep::kNone;
  double points_at_one = 0;
  std::vector<Vec3d> reach;
  std::vector<uint32_t> edges, chunks;
  std::vector<float> bounds, raised;
  std::vector<double> tolerances;
  int finished = 0;

 private:
  absl::Status Pass(SliceStep step) const {
    return step == fails ? absl::ResourceExhaustedError("told to fail") : absl::OkStatus();
  }
  const ViewSpec spec_{};
};

class ToleranceExchangeTest : public ::testing::Test {
 protected:
  void SetUp() override {
    PolygonMesh mesh = TorusMesh(16, 9);
    const LatticeStructure structure = MakeStructure(mesh.ComputeBounds(), {});
    plan_ = MakeTestPlan(std::move(mesh), structure);
    ASSERT_NE(plan_, nullptr);
    shared_ = std::make_shared<const SharedEdges>(SharedEdges::Find(*plan_, first_chunks_));
    ASSERT_GT(shared_->edges.size(), 2u);
    a_.reach = {{1, 2, 3}};
    b_.reach = {{3, 2, 1}};
  }
  absl::StatusOr<std::unique_ptr<ToleranceExchange>> Create(const ViewSpec& spec) {
    const std::array<DeformView*, 2> views{&a_, &b_};
    return ToleranceExchange::Create(*plan_, spec, shared_, views);
  }
  absl::Status Evaluate(ToleranceExchange& exchange) {
    const std::vector<uint32_t> all{0, 1}, none;
    const std::array<std::span<const uint32_t>, 2> chunks{all, none};
    return exchange.Evaluate(plan_->identity_points, QuantisationBox{.range = 1}, chunks);
  }

  // The bound that a slice has of a shared edge, by the edge's number.
  float& Bound(FakeSlice& slice, size_t edge) { return slice.bounds[PlaceOf(slice, edge)]; }
  float Raised(const FakeSlice& slice, size_t edge) { return slice.raised[PlaceOf(slice, edge)]; }
  size_t PlaceOf(const FakeSlice& slice, size_t edge) {
    const auto& numbers = shared_->slices[&slice == &a_ ? 0 : 1].numbers;
    return static_cast<size_t>(std::ranges::find(numbers, edge) - numbers.begin());
  }

  const std::vector<uint32_t> first_chunks_{0, 3};
  Plan plan_;
  std::shared_ptr<const SharedEdges> shared_;
  FakeSlice a_, b_;
};

TEST_F(ToleranceExchangeTest, SlicesGetTheMaximaOfAll) {
  ASSERT_OK_AND_ASSIGN(const auto exchange, Create({.tolerance = 1}));
  EXPECT_EQ(a_.reach, (std::vector<Vec3d>{{3, 2, 3}}));
  EXPECT_EQ(b_.reach, a_.reach);
  // Two slices share all of these edges.
  ASSERT_EQ(a_.bounds.size(), shared_->edges.size());
  ASSERT_EQ(b_.bounds.size(), shared_->edges.size());
  Bound(a_, 0) = 5, Bound(b_, 0) = 4;
  Bound(a_, 1) = 6, Bound(b_, 1) = 7;
  Bound(a_, 2) = kNotANumber, Bound(b_, 2) = 8;

  ASSERT_OK(Evaluate(*exchange));

  EXPECT_EQ(a_.chunks, (std::vector<uint32_t>{0, 1}));
  EXPECT_TRUE(b_.chunks.empty());
  for (const FakeSlice* slice : {&a_, &b_}) {
    EXPECT_EQ(Raised(*slice, 0), 5);
    EXPECT_EQ(Raised(*slice, 1), 7);
    EXPECT_TRUE(std::isnan(Raised(*slice, 2)));
    EXPECT_EQ(slice->finished, 1);
  }
}

TEST_F(ToleranceExchangeTest, TheToleranceIsDoubledForThePointsOfAll) {
  const double most = 3 * static_cast<double>(plan_->patches.size());  // of one segment
  ASSERT_OK_AND_ASSIGN(const auto exchange,
                       Create({.segments = 1, .tolerance = 1, .format = VertexFormat::kFloat32}));
  a_.points_at_one = b_.points_at_one = 1.45 * most;  // together 2.9, then 1.45 and 0.73

  ASSERT_OK(Evaluate(*exchange));

  ASSERT_EQ(a_.tolerances.size(), 3u);
  EXPECT_EQ(b_.tolerances, a_.tolerances);
  EXPECT_NEAR(a_.tolerances[0], 1, 1e-6);
  EXPECT_NEAR(a_.tolerances[2], 4, 1e-6);
}

// No slice takes a later step, not even the one that did not fail. The next evaluation is as if nothing had happened.
TEST_F(ToleranceExchangeTest, AStepThatFailsEndsTheEvaluation) {
  b_.fails = SliceStep::kReach;
  EXPECT_THAT(Create({.tolerance = 1}), StatusIs(absl::StatusCode::kResourceExhausted));
  EXPECT_TRUE(a_.edges.empty()) << "edges were shared";
  b_.fails = SliceStep::kShare;
  EXPECT_THAT(Create({.tolerance = 1}), StatusIs(absl::StatusCode::kResourceExhausted));
  b_.fails = SliceStep::kNone;
  ASSERT_OK_AND_ASSIGN(const auto exchange, Create({.tolerance = 1}));
  for (const SliceStep step : {SliceStep::kBound, SliceStep::kSharedBounds, SliceStep::kChoose,
                               SliceStep::kCount, SliceStep::kFinish}) {
    SCOPED_TRACE(static_cast<int>(step));
    a_.tolerances.clear(), b_.tolerances.clear();
    a_.finished = b_.finished = 0;
    b_.fails = step;

    EXPECT_THAT(Evaluate(*exchange), StatusIs(absl::StatusCode::kResourceExhausted));

    const bool chosen = step >= SliceStep::kChoose, finished = step >= SliceStep::kFinish;
    EXPECT_EQ(a_.tolerances.size(), chosen ? 1u : 0u);
    EXPECT_EQ(b_.tolerances.size(), chosen ? 1u : 0u);
    EXPECT_EQ(a_.finished, finished ? 1 : 0);
    EXPECT_EQ(b_.finished, finished ? 1 : 0);

    b_.fails = SliceStep::kNone;
    ASSERT_OK(Evaluate(*exchange));
    EXPECT_EQ(a_.tolerances.back(), b_.tolerances.back());
    EXPECT_EQ(a_.finished, finished ? 2 : 1);
    EXPECT_EQ(b_.finished, finished ? 2 : 1);
  }
}

TEST_F(ToleranceExchangeTest, AViewWithoutStepsIsRefused) {
  class Whole : public FakeSlice {
   public:
    ToleranceSlice* tolerance_slice() override { return nullptr; }
  } whole;
  const std::array<DeformView*, 2> views{&a_, &whole};

  const auto exchange = ToleranceExchange::Create(*plan_, {.tolerance = 1}, shared_, views);

  ASSERT_THAT(exchange, StatusIs(absl::StatusCode::kInvalidArgument));
  EXPECT_EQ(error::DetailsOf(exchange.status()).reason, "UNSUPPORTED");
  EXPECT_EQ(error::DetailsOf(exchange.status()).field, "view.tolerance");
}

}  // namespace
}  // namespace latticed::testing
