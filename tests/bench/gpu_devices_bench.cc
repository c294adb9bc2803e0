// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// One scene on one, two and four devices (core/view/device_group.h), all of one run:
//
//   the row's time  by the host's clock, from the call of Evaluate until the last device is done:
//                   the copies of control points are in it, and one device's launch after another's
//   enqueue_ms      of that, until Evaluate returns
//   ratio           the time on one device / this one
//
// Nothing is brought to the host, as in all rows of the GPU. No cache is flushed: the vertices of
// 10^7 patches are a hundred times what it holds and more, quantised ones of 10^5 just as much.
#include <map>
#include <string>
#include <utility>

#include "fmt/format.h"
#include "tests/bench/benches.h"
#include "tests/bench/gpu_scenario.h"

namespace latticed::bench {
namespace {

constexpr int kRuns = 50;
constexpr int kCounts[]{1, 2, 4};
constexpr size_t kLarge = 10'000'000;
constexpr size_t kScale[]{100'000, 1'000'000, kLarge};

const char* Name(VertexFormat format) {
  return format == VertexFormat::kQuantised ? "quantised" : "float32";
}

// Milliseconds on one device, of the rows before.
std::map<std::pair<size_t, VertexFormat>, double>& OnOne() {
  static auto* const times = new std::map<std::pair<size_t, VertexFormat>, double>;
  return *times;
}

void Span(benchmark::State& state, size_t patches, VertexFormat format, int devices) {
  Gpu& gpu = **TheGpu();
  const Scenario& scenario = ScaleScenario(patches);
  const auto backend = gpu.OnDevices(devices);
  const auto view =
      MakeGpuView(*backend, scenario, Pipeline::kFused, GpuSpec(format, NormalMode::kFacet, 10));
  if (!view.ok()) return Skip(state, view.status());
  const WallTimes times = gpu.WallTime(**view, AllChunks(scenario, **view), kRuns);
  SetTime(state, times.whole);
  state.counters["patches"] = static_cast<double>(scenario.plan->patches.size());
  state.counters["devices"] = devices;
  state.counters["enqueue_ms"] = times.enqueue_ms;
  if (devices == 1) OnOne()[{patches, format}] = times.whole.median;
  const auto on_one = OnOne().find({patches, format});
  if (on_one != OnOne().end()) {
    state.counters["ratio"] = on_one->second / times.whole.median;
  }
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
