// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/cpu/gemm/cpu_gemm.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "core/cpu/cpu_backend.h"
#include "tests/support/status_matchers.h"

namespace latticed {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using testing::StatusIs;

TEST(CpuGemm, TwoByThreeByTwoByHand) {
  // [1 3 5; 2 4 6] * [1 4; 2 5; 3 6], with an unused row in the strides of a, b and c.
  const std::vector<float> a{1, 2, 9, 3, 4, 9, 5, 6, 9}, b{1, 2, 3, 9, 4, 5, 6, 9};
  std::vector<float> c(6, -1);

  ASSERT_OK(CpuGemm(MatrixView<const float>{a.data(), 2, 3, 3},
                    MatrixView<const float>{b.data(), 3, 2, 4},
                    MatrixView<float>{c.data(), 2, 2, 3}));

  EXPECT_EQ(c, (std::vector<float>{22, 28, -1, 49, 64, -1}));
}

TEST(CpuGemm, DoublesKeepTheirDigits) {
  const std::vector<double> a{1, 1e-15}, b{1, 1};
  double c = 0;

  ASSERT_OK(CpuGemm(MatrixView<const double>{a.data(), 1, 2, 1},
                    MatrixView<const double>{b.data(), 2, 1, 2}, MatrixView<double>{&c, 1, 1, 1}));

  EXPECT_GT(c, 1);
}

TEST(CpuGemm, RefusesShapesThatDoNotFit) {
  std::vector<float> x(12);
  const auto view = [&](size_t rows, size_t columns, size_t stride) {
    return MatrixView<float>{x.data(), rows, columns, stride};
  };
  constexpr auto kInternal = absl::StatusCode::kInternal;

  EXPECT_THAT(CpuGemm(view(2, 3, 2), view(2, 2, 2), view(2, 2, 2)), StatusIs(kInternal));
  EXPECT_THAT(CpuGemm(view(2, 3, 2), view(3, 2, 3), view(3, 2, 3)), StatusIs(kInternal));
  EXPECT_THAT(CpuGemm(view(2, 3, 1), view(3, 2, 3), view(2, 2, 2)), StatusIs(kInternal));
}

TEST(CpuBlas, NamesItsCore) { EXPECT_FALSE(CpuBlasCoreName().empty()); }

// Another version may round otherwise. Only products are its affair.
TEST(CpuBlas, ItsVersionIsOfTheArithmeticOfProducts) {
  const std::unique_ptr<Backend> cpu = MakeCpuBackend({.threads = 1});
  for (const Pipeline pipeline : {Pipeline::kGemm, Pipeline::kGemm12, Pipeline::kControlNet}) {
    EXPECT_THAT(cpu->Arithmetic(pipeline),
                AllOf(HasSubstr("OpenBLAS 0."), HasSubstr(CpuBlasCoreName())));
  }
  EXPECT_EQ(cpu->Arithmetic(Pipeline::kFused), "");
}

}  // namespace
}  // namespace latticed
