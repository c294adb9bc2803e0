// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// One scene on one, two and four devices (core/view/device_group.h), all in one run:
//
//   the row's time  by the host's clock, from the call of Evaluate until the last device is done;
//                   includes copying control points and launching on one device after another
//   enqueue_ms      the part until Evaluate returns
//   ratio           the time on one device / this time
//
// Like most GPU rows, these bring nothing to the host. The rows "draco" end when all Draco bytes of
// the update, 12 and 8 bits, are in pinned host memory. They encode in batches and keep the previous
// update meanwhile, as the server does. No cache is flushed: the vertices of 10^7 patches take more
// than a hundred times the L2 cache, and the quantised ones of 10^5 patches about all of it.
#include <algorithm>
#include <chrono>
#include <map>
#include <string>
#include <utility>

#include "fmt/format.h"
#include "tests/bench/benches.h"
#include "tests/bench/gpu/gpu_scenario.h"

namespace latticed::bench {
namespace {

constexpr int kDeviceRuns = 50, kByteRuns = 10, kByteWarmUps = 3;
constexpr int kCounts[]{1, 2, 4};
constexpr size_t kLarge = 10'000'000;
constexpr size_t kScale[]{100'000, 1'000'000, kLarge};

const char* Name(VertexFormat format) {
  return format == VertexFormat::kQuantised ? "quantised" : "float32";
}

// Milliseconds on one device, from earlier rows, by patches and kind.
std::map<std::pair<size_t, std::string>, double>& OnOne() {
  static auto* const times = new std::map<std::pair<size_t, std::string>, double>;
  return *times;
}

void SetRatio(benchmark::State& state, size_t patches, const std::string& kind, int devices,
              double median) {
  state.counters["devices"] = devices;
  if (devices == 1) OnOne()[{patches, kind}] = median;
  const auto on_one = OnOne().find({patches, kind});
  if (on_one != OnOne().end()) state.counters["ratio"] = on_one->second / median;
}

void Span(benchmark::State& state, size_t patches, VertexFormat format, int devices) {
  Gpu& gpu = **TheGpu();
  const Scenario& scenario = ScaleScenario(patches);
  const auto backend = gpu.OnDevices(devices);
  const auto view =
      MakeGpuView(*backend, scenario, Pipeline::kFused, GpuSpec(format, NormalMode::kFacet, 10));
  if (!view.ok()) return Skip(state, view.status());
  const WallTimes times = gpu.WallTime(**view, AllChunks(scenario, **view), kDeviceRuns);
  SetTime(state, times.whole);
  state.counters["patches"] = static_cast<double>(scenario.plan->patches.size());
  state.counters["enqueue_ms"] = times.enqueue_ms;
  SetRatio(state, patches, Name(format), devices, times.whole.median);
}

std::vector<SharedBytes> EncodeAll(DeformView& view, const ViewTraits& traits,
                                   std::span<const uint32_t> chunks) {
  std::vector<SharedBytes> all;
  all.reserve(chunks.size());
  const std::vector<uint32_t> order = EncodeOrder(traits, chunks);
  for (size_t done = 0; done < order.size();) {
    const size_t count = std::min(traits.encode_batch, order.size() - done);
    std::ranges::move(
        Checked(view.Encode(std::span(order).subspan(done, count), Encoding::kDracoPoints)),
        std::back_inserter(all));
    done += count;
  }
  return all;
}

void SpanToBytes(benchmark::State& state, size_t patches, int devices) {
  using Clock = std::chrono::steady_clock;
  Gpu& gpu = **TheGpu();
  const Scenario& scenario = ScaleScenario(patches);
  const auto backend = gpu.OnDevices(devices);
  const ViewSpec spec = GpuSpec(VertexFormat::kQuantised, NormalMode::kFacet, 10);
  const auto view = MakeGpuView(*backend, scenario, Pipeline::kFused, spec);
  if (!view.ok()) return Skip(state, view.status());
  const ViewTraits traits =
      Checked(backend->Prepare(scenario.plan, Pipeline::kFused))->Traits(spec);
  const GpuWork evaluate = AllChunks(scenario, **view);
  std::vector<SharedBytes> newest;
  std::vector<double> times;
  for (int run = 0; run < kByteWarmUps + kByteRuns; ++run) {
    const auto start = Clock::now();
    CheckOk(evaluate(run));
    auto streams = EncodeAll(**view, traits, scenario.all_chunks);
    const std::chrono::duration<double, std::milli> time = Clock::now() - start;
    newest = std::move(streams);
    if (run >= kByteWarmUps) times.push_back(time.count());
  }
  uint64_t bytes = 0;
  for (const SharedBytes& stream : newest) bytes += stream.size;
  SetTime(state, MedianAndLeast(times));
  state.counters["patches"] = static_cast<double>(scenario.plan->patches.size());
  state.counters["bytes"] = static_cast<double>(bytes);
  SetRatio(state, patches, "draco", devices, MedianAndLeast(times).median);
}

}  // namespace

void RegisterGpuDevicesBenches(bool large) {
  const int present = (**TheGpu()).device_count();
  for (const int devices : kCounts) {
    if (devices <= present) continue;
    fmt::print(stderr, "latticed_bench: no rows of {} devices: this machine has {}\n", devices,
               present);
  }
  if (present == 1) return;
  for (const size_t patches : kScale) {
    if (patches == kLarge && !large) continue;
    for (const int devices : kCounts) {
      if (devices > present) continue;
      RegisterOnce(
          fmt::format("gpu/scale-{}-on-{}/fused/2x2x2/draco/facet/10segments", patches, devices),
          [patches, devices](benchmark::State& state) { SpanToBytes(state, patches, devices); });
    }
    for (const VertexFormat format : {VertexFormat::kFloat32, VertexFormat::kQuantised}) {
      for (const int devices : kCounts) {
        if (devices > present) continue;
        RegisterOnce(fmt::format("gpu/scale-{}-on-{}/fused/2x2x2/{}/facet/10segments", patches,
                                 devices, Name(format)),
                     [patches, format, devices](benchmark::State& state) {
                       Span(state, patches, format, devices);
                     });
      }
    }
  }
}

}  // namespace latticed::bench
