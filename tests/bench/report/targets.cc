// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/report/targets.h"

#include <array>
#include <utility>
#include <vector>

#include "fmt/format.h"
#include "tests/bench/model_scenarios.h"

namespace latticed::bench {
namespace {

// The value is `numerator` / `denominator`, or `numerator` alone. Each names a benchmark, whose
// time is in milliseconds, or "benchmark:counter".
struct Target {
  std::string text;
  std::string numerator, denominator;
  bool at_least = true;
  double target = 0;
};
using Targets = std::vector<Target>;

void AddCpu(Targets& targets) {
  const std::string s = "evaluate/torus-17k/";
  const std::string lane = s + "fused/degree2/lane-order/facet/10segments/";
  const std::string streamed = s + "fused/degree2/quantised/facet/10segments/";
  const std::string gemm = s + "gemm/degree2/point-order/facet/10segments/1t";
  const Targets cpu{
      {"gemm / fused, lane order", gemm, lane + "1t", true, 12},
      {"blocked product alone / fused, lane order", "floor/blocked-product-alone/1t", lane + "1t",
       true, 2},
      {"fused, lane order / streaming stores", lane + "1t", "floor/streaming-stores/1t", false, 3},
      {"gemm / fused as streamed (12/8 bits)", gemm, streamed + "1t", true, 9},
      {"fused as streamed, ms", streamed + "1t", "", false, 4.5},
      {"fused, one thread / two", lane + "1t", lane + "2t", true, 1.7},
      {"fused as streamed, one thread / two", streamed + "1t", streamed + "2t", true, 1.7},
      {"smooth / facet normals", s + "fused/degree2/lane-order/smooth/10segments/1t", lane + "1t",
       false, 1.8},
      {"delivery of raw chunks on one stream, GB/s", "delivery/raw-chunks:GB_s", "", true, 2},
      {"plan of 100,000 faces, ms", "plan/100000-faces", "", false, 500},
      {"plan, 100,000 faces / 25,000", "plan/100000-faces", "plan/25000-faces", false, 4.8},
  };
  targets.insert(targets.end(), cpu.begin(), cpu.end());
}

// The Draco writer, under AVX-512 ("AVX3"), AVX2 and without vectors.
void AddCodec(Targets& targets) {
  const std::string codec = "codec/torus-17k/", ours = codec + "latticed/", bytes = ":bytes_point";
  const std::string theirs = codec + "libdraco", best = ours + "AVX3/integers";
  const Targets rows{
      {"libdraco / Draco writer, from floats", theirs, ours + "AVX3/floats", true, 5},
      {"libdraco / Draco writer, from integers", theirs, best, true, 8},
      {"libdraco / Draco writer, from integers, AVX2", theirs, ours + "AVX2/integers", true, 5},
      {"libdraco / Draco writer, from integers, scalar", theirs, ours + "SCALAR/integers", true,
       3.5},
      {"libdraco / Draco writer, from floats, scalar", theirs, ours + "SCALAR/floats", true, 3.5},
      {"bytes of the Draco writer / libdraco's", best + bytes, theirs + bytes, false, 1},
      {"bytes row by row / serpentine", ours + "row-order" + bytes, best + bytes, true, 1 / 0.9},
      {"17,119 patches, edit to bytes on two cores, ms", "encode/edit-to-bytes/bird-17119/2t", "",
       false, 15},
      {"Draco streams of a view, one thread / two", "encode/torus-17k/draco-points/1t",
       "encode/torus-17k/draco-points/2t", true, 1.7},
  };
  targets.insert(targets.end(), rows.begin(), rows.end());
  for (const char* model : kModelNames) {
    for (const char* normals : {"facet", "smooth"}) {
      const std::string its = fmt::format("codec/bytes/{}/{}/12-8", model, normals);
      targets.push_back({fmt::format("bytes row by row / serpentine, {}, {}", model, normals),
                         its + ":row_by_row_bytes_point", its + bytes, true, 1 / 0.9});
    }
  }
}

void AddStreaming(Targets& targets) {
  for (const char* backend : {"cpu", "cuda"}) {
    targets.push_back(
        {fmt::format("{}: p99 of 1,000 patches beside 1,000,000, of its bound", backend),
         fmt::format("fairness/{}:of_bound", backend), "", false, 1});
  }
}

// Times with and without the copy of control points, since the targets come from kernels alone.
void AddGpu(Targets& targets) {
  const std::string tree = "gpu/tree-113663/fused/2x2x2/", bird = "gpu/bird-17119/fused/2x2x2/";
  const std::string facet = "float32/facet/10segments", quantised = "quantised/facet/10segments";
  const std::string gemm = "gpu/tree-113663/gemm/2x2x2/" + facet, kernels = ":kernels_ms";
  const Targets gpu{
      {"GPU 113,663 float32, share of write bandwidth", tree + facet + ":write_share", "", true,
       0.85},
      {"GPU 113,663 float32, gemm / fused", gemm, tree + facet, true, 10},
      {"GPU 113,663 float32, gemm / fused, kernels", gemm + kernels, tree + facet + kernels, true,
       10},
      {"GPU 113,663 quantised, ms", tree + quantised, "", false, 0.040},
      {"GPU 113,663 quantised, ms, kernels", tree + quantised + kernels, "", false, 0.040},
      {"GPU 17,119 float32, ms", bird + facet, "", false, 0.012},
      {"GPU 17,119 float32, ms, kernels", bird + facet + kernels, "", false, 0.012},
      {"GPU 17,119 quantised, ms", bird + quantised, "", false, 0.012},
      {"GPU 17,119 quantised, ms, kernels", bird + quantised + kernels, "", false, 0.012},
      {"GPU smooth / facet normals, float32, kernels", tree + "float32/smooth/10segments" + kernels,
       tree + facet + kernels, false, 1.8},
      {"GPU smooth / facet normals, quantised, kernels",
       tree + "quantised/smooth/10segments" + kernels, tree + quantised + kernels, false, 1.8},
      {"GPU 113,663 plan, facet normals, bytes a patch",
       "gpu/plan-memory/tree-113663/fused/facet:bytes_patch", "", false, 64},
      {"GPU 113,663 plan, smooth normals, bytes a patch",
       "gpu/plan-memory/tree-113663/fused/smooth:bytes_patch", "", false, 96},
  };
  targets.insert(targets.end(), gpu.begin(), gpu.end());
  for (const char* row : {"float32/most", "float32/median", "quantised/most", "quantised/median"}) {
    targets.push_back({fmt::format("GPU one control point, {}, launch to result, ms", row),
                       fmt::format("gpu/one-control-point/fused/{}", row), "", false, 0.030});
  }
}

// From edits to Draco bytes in host memory.
void AddGpuEncode(Targets& targets) {
  const std::string tree = "gpu/edit-to-bytes/tree-113663/", bird = "gpu/edit-to-bytes/bird-17119/";
  const Targets rows{
      {"GPU 113,663 Draco writer, ns a point", tree + "all:ns_point", "", false, 0.25},
      {"GPU 17,119 Draco writer, ns a point", bird + "all:ns_point", "", false, 0.5},
      {"GPU 113,663 edit to bytes, ms", tree + "all", "", false, 2.5},
      {"GPU 113,663 edit to bytes, tolerance of 1e-4, ms", tree + "all/tolerance-1e-4", "", false,
       0.35},
      {"GPU 113,663 edit to bytes, p99 / p50", tree + "all:p99_over_p50", "", false, 1.5},
      {"GPU 17,119 edit to bytes, ms", bird + "all", "", false, 0.7},
      {"GPU 17,119 edit to bytes, p99 / p50", bird + "all:p99_over_p50", "", false, 1.5},
      {"GPU 113,663 edit to bytes, one control point, ms", tree + "one-control-point", "", false,
       0.6},
  };
  targets.insert(targets.end(), rows.begin(), rows.end());
}

// Other shapes, as a share of their larger lower bound; and time per patch, compared with 10^5 patches.
void AddGpuShapes(Targets& targets) {
  for (const char* format : {"float32", "quantised"}) {
    for (const char* shape :
         {"1x1x1 10", "3x3x3 10", "1x2x3 10", "2x2x2 1", "2x2x2 4", "2x2x2 20"}) {
      const std::string degree(shape, 5), segments(shape + 6);
      targets.push_back(
          {fmt::format("GPU {} {}, {} segments, of its floor", format, degree, segments),
           fmt::format("gpu/tree-113663/fused/{}/{}/facet/{}segments:of_floor", degree, format,
                       segments),
           "", true, 0.65});
    }
    const auto scale = [&](const char* patches) {
      return fmt::format("gpu/scale-{}/fused/2x2x2/{}/facet/10segments:ns_patch", patches, format);
    };
    for (const char* patches : {"1000000", "10000000"}) {
      targets.push_back({fmt::format("GPU {} time a patch, {} / 100000", format, patches),
                         scale(patches), scale("100000"), false, 1.1});
    }
  }
}

// One scene on several devices, compared with one device.
void AddDevices(Targets& targets) {
  for (const char* format : {"float32", "quantised"}) {
    const auto row = [&](int devices) {
      return fmt::format("gpu/scale-10000000-on-{}/fused/2x2x2/{}/facet/10segments", devices,
                         format);
    };
    for (const auto& [devices, ratio] : {std::pair{2, 1.9}, {4, 3.7}}) {
      targets.push_back({fmt::format("GPU {} 10000000, one device / {}", format, devices), row(1),
                         row(devices), true, ratio});
    }
  }
}

}  // namespace

Section TargetSection(const std::map<std::string, double>& values) {
  Targets targets;
  AddCpu(targets);
  AddCodec(targets);
  AddStreaming(targets);
  AddGpu(targets);
  AddGpuShapes(targets);
  AddGpuEncode(targets);
  AddDevices(targets);
  Section section{
      .title = "Targets", .notes = {}, .columns = {"in this run", "measured", "", "target", ""}};
  for (const Target& t : targets) {
    const auto numerator = values.find(t.numerator);
    const auto denominator = values.find(t.denominator);
    if (numerator == values.end()) continue;
    if (!t.denominator.empty() && denominator == values.end()) continue;
    const double value =
        t.denominator.empty() ? numerator->second : numerator->second / denominator->second;
    const bool met = t.at_least ? value >= t.target : value <= t.target;
    section.rows.push_back({t.text, fmt::format("{:.4g}", value), t.at_least ? ">=" : "<=",
                            fmt::format("{:.4g}", t.target), met ? "met" : "missed"});
  }
  return section;
}

}  // namespace latticed::bench
