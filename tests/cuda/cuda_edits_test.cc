// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// An edit allocates nothing: what an evaluation needs is there once there was one, and what an encoding
// of chunks on the host needs once there was one.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cuda/cuda_backend.h"
#include "fmt/format.h"
#include "tests/cuda/cuda_test.h"

namespace latticed::testing {
namespace {

constexpr int kEdits = 10;

class CudaEdits : public CudaTest {
 protected:
  CudaEdits() : CudaTest(23) {}

  void SetUp() override {
    CudaTest::SetUp();
    if (IsSkipped() || HasFatalFailure()) return;
    box_ = BoxFor(*plan_, points_);
  }

  struct Scene {
    std::shared_ptr<DeformTarget> target;
    std::unique_ptr<DeformView> view;
  };
  // Evaluated once, at points_.
  absl::StatusOr<Scene> Make(Backend& backend, Pipeline pipeline, const ViewSpec& spec) {
    auto target = backend.Prepare(plan_, pipeline);
    if (!target.ok()) return target.status();
    auto view = (*target)->CreateView(spec);
    if (!view.ok()) return view.status();
    if (auto s = (*view)->Evaluate(points_, box_, AllChunks(*plan_)); !s.ok()) return s;
    return Scene{*std::move(target), *std::move(view)};
  }
  // Of all chunks.
  absl::StatusOr<std::vector<std::vector<uint8_t>>> Encode(DeformView& view, Encoding encoding) {
    const auto encoded = view.Encode(AllChunks(*plan_), encoding);
    if (!encoded.ok()) return encoded.status();
    std::vector<std::vector<uint8_t>> bytes;
    for (const SharedBytes& e : *encoded) bytes.emplace_back(e.span().begin(), e.span().end());
    return bytes;
  }
  // One control point after the other, by turns for all chunks and for one; at last for all.
  void Edit(DeformView& view) {
    for (int edit = 1; edit <= kEdits; ++edit) {
      points_[static_cast<size_t>(edit) * 7 % points_.size()].x += 0.01;
      const std::vector<uint32_t> all = AllChunks(*plan_), one{all.back()};
      ASSERT_OK(view.Evaluate(points_, box_, edit % 2 == 0 ? all : one)) << "edit " << edit;
    }
  }
  QuantisationBox box_;  // whose margin has room for all edits
};

TEST_F(CudaEdits, NothingIsAllocatedAfterTheFirst) {
  bool refuse = false;
  std::string asked;
  const auto backend = MakeCudaBackend(
      {.memory_bytes = 256 * kMiB, .refuse_allocation = [&](std::string_view purpose, uint64_t) {
         if (refuse) asked += fmt::format("{} ", purpose);
         return refuse;
       }});
  const auto other = MakeCudaBackend({.memory_bytes = 256 * kMiB});
  ASSERT_OK(backend);
  ASSERT_OK(other);
  for (const Encoding encoding : {Encoding::kQuantised, Encoding::kRaw}) {
    for (const Pipeline pipeline : kPipelines) {
      SCOPED_TRACE(
          fmt::format("{}, encoding {}", PipelineName(pipeline), static_cast<int>(encoding)));
      const ViewSpec spec{
          .segments = 4, .normals = NormalMode::kSmooth, .format = FormatOf(encoding)};
      const auto scene = Make(**backend, pipeline, spec);
      ASSERT_OK(scene);
      const auto first = Encode(*scene->view, encoding);
      ASSERT_OK(first);

      refuse = true;
      Edit(*scene->view);
      const auto edited = Encode(*scene->view, encoding);
      refuse = false;

      ASSERT_OK(edited);
      EXPECT_EQ(asked, "");
      EXPECT_FALSE(*edited == *first);
      const auto anew = Make(**other, pipeline, spec);
      ASSERT_OK(anew);
      const auto expected = Encode(*anew->view, encoding);
      ASSERT_OK(expected);
      EXPECT_TRUE(*edited == *expected) << "as if evaluated at once";
    }
  }
}

}  // namespace
}  // namespace latticed::testing
