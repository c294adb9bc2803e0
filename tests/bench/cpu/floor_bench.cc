// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Lower bounds of time on this machine: writing the vertices once by streaming stores; and, for the
// paper's form, product (25) alone, in tiles that stay in the L2 cache, without samples, normals or
// rearranging. No blocked form is faster than that product.
#include <cstddef>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "core/cpu/gemm/cpu_gemm.h"
#include "fmt/format.h"
#include "hwy/aligned_allocator.h"
#include "hwy/cache_control.h"
#include "hwy/highway.h"
#include "tests/bench/benches.h"

namespace latticed::bench {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

constexpr size_t kPaperPatches = 17'119;
constexpr size_t kPointsPerPatch = 66;
constexpr size_t kFloatsPerPoint = 6;

void StreamOut(float* out, size_t count, float value) {
  const hn::ScalableTag<float> tag;
  const auto v = hn::Set(tag, value);
  for (size_t i = 0; i < count; i += hn::Lanes(tag)) hn::Stream(v, tag, out + i);
  hwy::FlushStream();
}

void Stores(benchmark::State& state, int threads) {
  const size_t count = kPaperPatches * kPointsPerPatch * kFloatsPerPoint / 64 * 64;
  const auto out = hwy::AllocateAligned<float>(count);
  float value = 0;
  for (auto _ : state) {
    value += 1;
    const size_t share = count / static_cast<size_t>(threads) / 64 * 64;
    std::vector<std::jthread> helpers;
    for (int t = 1; t < threads; ++t) {
      helpers.emplace_back(StreamOut, out.get() + static_cast<size_t>(t) * share, share, value);
    }
    StreamOut(out.get(), share, value);
  }
  state.counters["GB_s"] = benchmark::Counter(static_cast<double>(count * sizeof(float)) * 1e-9,
                                              benchmark::Counter::kIsIterationInvariantRate);
}

void BlockedProduct(benchmark::State& state) {
  constexpr int kRows = 3 * 66, kInner = 28, kTile = 128, kColumns = 3 * kTile;
  const std::vector<float> stack(size_t{kRows} * kInner, 0.25f);
  const std::vector<float> samples(size_t{kInner} * kColumns, 0.5f);
  std::vector<float> product(size_t{kRows} * kColumns);
  for (auto _ : state) {
    for (size_t patch = 0; patch < kPaperPatches; patch += kTile) {
      const absl::Status status =
          CpuGemm({stack.data(), kRows, kInner, kRows}, {samples.data(), kInner, kColumns, kInner},
                  {product.data(), kRows, kColumns, kRows});
      if (!status.ok()) return state.SkipWithError(std::string(status.message()).c_str());
    }
    benchmark::DoNotOptimize(product.data());
  }
}

}  // namespace

void RegisterFloorBenches() {
  for (const int threads : {1, 2}) {
    RegisterTimed(fmt::format("floor/streaming-stores/{}t", threads),
                  [threads](benchmark::State& state) { Stores(state, threads); });
  }
  RegisterTimed("floor/blocked-product-alone/1t", BlockedProduct);
}

}  // namespace latticed::bench
