// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// From an edit to all Draco bytes of its update in host memory, by the host's clock: Evaluate, then
// Encode with 12 and 8 bits and digests, as the server calls them. encode_ms is Encode alone,
// including downloads and waits; ns_point is encode_ms divided by the points of the chunks. Before
// timing, the streams are compared with those of the host's writer.
#include <algorithm>
#include <chrono>
#include <utility>

#include "core/codec/draco_writer.h"
#include "core/cpu/cpu_backend.h"
#include "fmt/format.h"
#include "tests/bench/benches.h"
#include "tests/bench/gpu/gpu_scenario.h"
#include "tests/support/encode_chunk.h"

namespace latticed::bench {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kBytesRuns = 200, kBytesWarmUps = 5;
constexpr size_t kComparedByteChunks = 64;

// All chunks, or those that the control point of most, median or least effect touches.
enum class Edited { kAll, kMostPoint, kMedianPoint, kLeastPoint };

double MillisecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

double Quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<size_t>(share * static_cast<double>(values.size() - 1))];
}

// The result of comparing some chunks with the host's writer, and libdraco's time for the same chunks.
struct Compared {
  absl::Status status;
  double libdraco_ns_point = 0;
};
Compared CompareWithHost(const Scenario& scenario, DeformView& view,
                         std::span<const uint32_t> chunks) {
  const auto streams = Checked(view.Encode(chunks, Encoding::kDracoPoints));
  const size_t stride = std::max<size_t>(1, chunks.size() / kComparedByteChunks);
  Compared compared;
  size_t points = 0;
  double milliseconds = 0;
  for (size_t i = 0; i < chunks.size(); i += stride) {
    const std::vector<uint8_t> bytes = ReadChunk(scenario, view, chunks[i]);
    const size_t its = bytes.size() / BytesPerPoint(view.spec());
    const auto integers = QuantisedVertices::FromBytes(bytes, its, view.spec().position_bits,
                                                       view.spec().normal_bits);
    const auto expected =
        Checked(testing::EncodePoints(DracoWriter(), integers, scenario.box.range));
    if (!std::ranges::equal(streams[i].span(), expected)) {
      return {absl::InternalError(fmt::format("chunk {} differs from the host's", chunks[i]))};
    }
    const auto start = Clock::now();
    CheckOk(testing::EncodePoints(*MakeReferenceEncoder(), integers, scenario.box.range).status());
    milliseconds += MillisecondsSince(start);
    points += its;
  }
  compared.libdraco_ns_point = 1e6 * milliseconds / static_cast<double>(points);
  return compared;
}

std::vector<uint32_t> ChunksOf(const Scenario& scenario, Edited edited) {
  if (edited == Edited::kAll) return scenario.all_chunks;
  const auto effects = ControlPointsByEffect(scenario);
  const size_t at = edited == Edited::kLeastPoint  ? 0
                    : edited == Edited::kMostPoint ? effects.size() - 1
                                                   : effects.size() / 2;
  return DirtyChunks(scenario, effects[at].point);
}

void EditToBytes(benchmark::State& state, Backend& backend, const PaperModel& model,
                 Edited edited) {
  const Scenario& scenario = ModelScenario(model, {2, 2, 2});
  const ViewSpec spec = GpuSpec(VertexFormat::kQuantised, NormalMode::kFacet, 10);
  const auto view = MakeGpuView(backend, scenario, Pipeline::kFused, spec);
  if (!view.ok()) return Skip(state, view.status());
  const auto chunks = ChunksOf(scenario, edited);
  const Compared compared = CompareWithHost(scenario, **view, chunks);
  if (!compared.status.ok()) return Skip(state, compared.status);
  std::vector<VertexDigest> digests(chunks.size());
  std::vector<double> whole, encode;
  size_t bytes = 0;
  for (int run = 0; run < kBytesRuns + kBytesWarmUps; ++run) {
    const auto start = Clock::now();
    CheckOk((*view)->Evaluate(scenario.control_points[static_cast<size_t>(run + 1) % 2],
                              scenario.box, chunks));
    const auto streams = (*view)->Encode(chunks, Encoding::kDracoPoints, digests);
    const double both = MillisecondsSince(start);
    const auto again = Clock::now();
    CheckOk((*view)->Encode(chunks, Encoding::kDracoPoints).status());
    const double alone = MillisecondsSince(again);
    CheckOk(streams.status());
    if (run < kBytesWarmUps) continue;
    whole.push_back(both);
    encode.push_back(alone);
    bytes = 0;
    for (const SharedBytes& stream : *streams) bytes += stream.size;
  }
  size_t points = 0;
  for (const uint32_t chunk : chunks) points += ChunkPoints(*scenario.plan, chunk, spec.segments);
  const double encode_ms = Quantile(encode, 0.5);
  SetTime(state, MedianAndLeast(whole));
  state.counters["p99_over_p50"] = Quantile(whole, 0.99) / Quantile(whole, 0.5);
  state.counters["p99_ms"] = Quantile(whole, 0.99);
  state.counters["encode_ms"] = encode_ms;
  state.counters["ns_point"] = 1e6 * encode_ms / static_cast<double>(points);
  state.counters["libdraco_ns_point"] = compared.libdraco_ns_point;
  state.counters["bytes_point"] = static_cast<double>(bytes) / static_cast<double>(points);
  state.counters["chunks"] = static_cast<double>(chunks.size());
}

}  // namespace

void RegisterGpuEncodeBenches() {
  for (const PaperModel& model : {PaperModels().front(), PaperModels().back()}) {
    for (const auto& [name, edited] : {std::pair{"all", Edited::kAll},
                                       {"most-control-point", Edited::kMostPoint},
                                       {"one-control-point", Edited::kMedianPoint},
                                       {"least-control-point", Edited::kLeastPoint}}) {
      RegisterOnce(fmt::format("gpu/edit-to-bytes/{}-{}/{}", model.name, model.patches, name),
                   [model, edited = edited](benchmark::State& state) {
                     EditToBytes(state, (*TheGpu())->backend(), model, edited);
                   });
    }
  }
}

void RegisterCpuEncodeBenches() {
  const PaperModel model = PaperModels().front();
  for (const int threads : {1, 2}) {
    RegisterOnce(fmt::format("encode/edit-to-bytes/{}-{}/{}t", model.name, model.patches, threads),
                 [model, threads](benchmark::State& state) {
                   const auto backend = MakeCpuBackend({.threads = threads});
                   EditToBytes(state, *backend, model, Edited::kAll);
                 });
  }
}

}  // namespace latticed::bench
