// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How many bytes our writer takes for whole updates of real models. Counted, not timed: as
// codec_bytes_bench.cc, whose tables are in results/cpu.md.
#include "tests/bench/codec/codec_bytes.h"

#include <gtest/gtest.h>

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "core/ffd/tessellation_pattern.h"
#include "tests/bench/codec/row_order.h"
#include "tests/bench/model_scenarios.h"
#include "tests/support/status_matchers.h"

namespace latticed::bench {
namespace {

// Where libdraco picks its tagged scheme, it may take so much less: 0.007 % of spot at 12 bits.
constexpr double kMostBehindLibdraco = 1e-4;

constexpr double kLeastSaved = 0.1;

class RealMeshBytes : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    if (!HasModel(GetParam())) GTEST_SKIP() << "no " << GetParam() << " in $LATTICED_SHARED/models";
  }
};

TEST_P(RealMeshBytes, AreNoMoreThanLibdracosAndTenPercentLessThanRowByRow) {
  for (const NormalMode normals : {NormalMode::kFacet, NormalMode::kSmooth}) {
    for (const auto& [position_bits, normal_bits] : {std::pair{11, 8}, {12, 8}, {14, 10}}) {
      SCOPED_TRACE(::testing::Message()
                   << (normals == NormalMode::kFacet ? "facet" : "smooth") << " normals, "
                   << position_bits << " and " << normal_bits << " bits");
      const auto bytes = CodecBytes::Count(
          ModelScenario(GetParam()),
          {.normals = normals, .position_bits = position_bits, .normal_bits = normal_bits});
      ASSERT_OK(bytes);

      EXPECT_LT(bytes->tagged_chunks, bytes->chunks) << "nothing to compare";
      EXPECT_LE(bytes->more_elsewhere, 0);
      EXPECT_LE(bytes->more_than_libdraco(), kMostBehindLibdraco);
      EXPECT_GE(bytes->saved_by_serpentine(), kLeastSaved);
    }
  }
}

// Each point is its barycentrics, its patch, and one of them again.
TEST(RowByRow, RunsAllRowsTheSameWay) {
  constexpr size_t kPatches = 3;
  for (const auto& [segments, normal_bits] : {std::pair{1, 8}, {4, 10}, {10, 8}}) {
    const auto& pattern = TessellationPattern::Get(segments).points;
    const ViewSpec spec{.segments = segments, .normal_bits = normal_bits};
    const size_t points = kPatches * pattern.size(), normal_bytes = normal_bits <= 8 ? 1 : 2;
    std::vector<uint8_t> integers(points * BytesPerPoint(spec));
    const auto plane = [&](std::vector<uint8_t>& bytes, size_t component,
                           size_t point) -> uint8_t& {
      return component < 3 ? bytes[2 * (component * points + point)]
                           : bytes[6 * points + normal_bytes * ((component - 3) * points + point)];
    };
    for (size_t i = 0; i < points; ++i) {
      const auto& [i0, i1, i2] = pattern[i % pattern.size()];
      const std::array values{i0, i1, i2, static_cast<uint8_t>(i / pattern.size()), i1};
      for (size_t c = 0; c < values.size(); ++c) plane(integers, c, i) = values[c];
    }

    std::vector<uint8_t> rows = RowByRow(integers, spec);

    ASSERT_EQ(rows.size(), integers.size());
    size_t i = 0;
    for (size_t patch = 0; patch < kPatches; ++patch) {
      for (int row = 0; row <= segments; ++row) {
        for (int column = 0; column <= segments - row; ++column, ++i) {
          const std::array expected{segments - row - column, column, row, static_cast<int>(patch),
                                    column};
          for (size_t c = 0; c < expected.size(); ++c) {
            ASSERT_EQ(plane(rows, c, i), expected[c]) << segments << " segments, point " << i;
          }
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, RealMeshBytes, ::testing::ValuesIn(kModelNames),
                         [](const auto& info) {
                           std::string name = info.param;
                           std::erase(name, '-');
                           return name;
                         });

}  // namespace
}  // namespace latticed::bench
