// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// From an edit to all Draco bytes of its update in host memory, or with "meshopt" to all meshopt bytes, by the host's
// clock: Evaluate, then Encode with 12 and 8 bits, or 14 and 8 with a tolerance, and digests, as the server calls them.
// encode_ms is Encode alone, including downloads and waits; ns_point is encode_ms divided by the points of the chunks, and
// bytes_point the bytes that reach the host. Before timing, the streams are compared with those of the host's writer.
//
// Rows "…/patches": the same to the bytes of bounds, which are verified before (verify_bounds.h).
#include <algorithm>
#include <chrono>
#include <utility>

#include "core/codec/draco_writer.h"
#include "core/codec/meshopt/meshopt_writer.h"
#include "core/cpu/cpu_backend.h"
#include "fmt/format.h"
#include "tests/bench/benches.h"
#include "tests/bench/gpu/gpu_scenario.h"
#include "tests/bench/verify_bounds.h"
#include "tests/support/encode_chunk.h"

namespace latticed::bench {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kBytesRuns = 200, kBytesWarmUps = 5;
constexpr size_t kComparedByteChunks = 64;
constexpr int kToleranceBits = 14;  // 12 cannot meet a tolerance of 1e-4

// All chunks, or those that the control point of most, median or least effect touches.
enum class Edited { kAll, kMostPoint, kMedianPoint, kLeastPoint };

double MillisecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

double Quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<size_t>(share * static_cast<double>(values.size() - 1))];
}

// What is edited and encoded.
struct EncodedCase {
  Edited edited = Edited::kAll;
  double share = 0;  // of the box's range: the tolerance; 0: 10 segments
  Encoding encoding = Encoding::kDracoPoints;
};

std::vector<uint8_t> EncodeOnHost(const QuantisedVertices& integers, double range,
                                  Encoding encoding) {
  if (encoding == Encoding::kMeshopt) return EncodeMeshopt(integers);
  return Checked(testing::EncodePoints(DracoWriter(), integers, range));
}

// The result of comparing some chunks with the host's writer, and libdraco's time for the same chunks.
struct Compared {
  absl::Status status;
  double libdraco_ns_point = 0;
};
Compared CompareWithHost(const Scenario& scenario, DeformView& view,
                         std::span<const uint32_t> chunks, Encoding encoding) {
  const auto streams = Checked(view.Encode(chunks, encoding));
  const size_t stride = std::max<size_t>(1, chunks.size() / kComparedByteChunks);
  Compared compared;
  size_t points = 0;
  double milliseconds = 0;
  for (size_t i = 0; i < chunks.size(); i += stride) {
    const std::vector<uint8_t> bytes = ReadChunk(scenario, view, chunks[i]);
    const size_t its = bytes.size() / BytesPerPoint(view.spec());
    auto integers = QuantisedVertices::FromBytes(bytes, its, view.spec().position_bits,
                                                 view.spec().normal_bits);
    integers.is_sparse = view.spec().tolerance > 0;
    const auto expected = EncodeOnHost(integers, scenario.box.range, encoding);
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

// A view with 10 segments or, if `share` is above 0, with this share of the box's range as its tolerance.
absl::StatusOr<std::unique_ptr<DeformView>> MakeView(Backend& backend, const Scenario& scenario,
                                                     double share) {
  ViewSpec spec = GpuSpec(VertexFormat::kQuantised, NormalMode::kFacet, 10);
  if (share == 0) return MakeGpuView(backend, scenario, Pipeline::kFused, spec);
  spec.position_bits = kToleranceBits;
  spec.tolerance = share * scenario.box.range;
  const auto target = Checked(backend.Prepare(scenario.plan, Pipeline::kFused));
  auto view = Checked(target->CreateView(spec));
  CheckOk(view->Evaluate(scenario.control_points[0], scenario.box, scenario.all_chunks));
  return view;
}

void EditToBytes(benchmark::State& state, Backend& backend, const PaperModel& model,
                 const EncodedCase& its) {
  const Scenario& scenario = ModelScenario(model, {2, 2, 2});
  const auto view = MakeView(backend, scenario, its.share);
  if (!view.ok()) return Skip(state, view.status());
  const auto chunks = ChunksOf(scenario, its.edited);
  const Compared compared = CompareWithHost(scenario, **view, chunks, its.encoding);
  if (!compared.status.ok()) return Skip(state, compared.status);
  std::vector<VertexDigest> digests(chunks.size());
  std::vector<double> whole, encode, evaluate;
  size_t bytes = 0;
  for (int run = 0; run < kBytesRuns + kBytesWarmUps; ++run) {
    const auto start = Clock::now();
    CheckOk((*view)->Evaluate(scenario.control_points[static_cast<size_t>(run + 1) % 2],
                              scenario.box, chunks));
    const double evaluated = MillisecondsSince(start);
    const auto streams = (*view)->Encode(chunks, its.encoding, digests);
    const double both = MillisecondsSince(start);
    const auto again = Clock::now();
    CheckOk((*view)->Encode(chunks, its.encoding).status());
    const double alone = MillisecondsSince(again);
    CheckOk(streams.status());
    if (run < kBytesWarmUps) continue;
    whole.push_back(both);
    encode.push_back(alone);
    evaluate.push_back(evaluated);
    bytes = 0;
    for (const SharedBytes& stream : *streams) bytes += stream.size;
  }
  size_t points = 0;
  for (const uint32_t chunk : chunks) points += ChunkPoints(**view, *scenario.plan, chunk);
  const double encode_ms = Quantile(encode, 0.5);
  SetTime(state, MedianAndLeast(whole));
  state.counters["p99_over_p50"] = Quantile(whole, 0.99) / Quantile(whole, 0.5);
  state.counters["p99_ms"] = Quantile(whole, 0.99);
  state.counters["evaluate_ms"] = Quantile(evaluate, 0.5);  // until the call returns
  state.counters["encode_ms"] = encode_ms;
  state.counters["ns_point"] = 1e6 * encode_ms / static_cast<double>(points);
  state.counters["libdraco_ns_point"] = compared.libdraco_ns_point;
  state.counters["bytes_point"] = static_cast<double>(bytes) / static_cast<double>(points);
  state.counters["chunks"] = static_cast<double>(chunks.size());
}

void EditToBounds(benchmark::State& state, Backend& backend, const PaperModel& model,
                  Edited edited) {
  const Scenario& scenario = ModelScenario(model, {2, 2, 2});
  const ViewSpec spec{.format = VertexFormat::kEdgeBounds};
  const auto target = Checked(backend.Prepare(scenario.plan, Pipeline::kFused));
  const auto view = Checked(target->CreateView(spec));
  if (const auto good = VerifyBounds(scenario, *view); !good.ok()) return Skip(state, good);
  const auto chunks = ChunksOf(scenario, edited);
  std::vector<VertexDigest> digests(chunks.size());
  std::vector<double> whole, encode, evaluate;
  size_t bytes = 0;
  for (int run = 0; run < kBytesRuns + kBytesWarmUps; ++run) {
    const auto start = Clock::now();
    CheckOk(view->Evaluate(scenario.control_points[static_cast<size_t>(run + 1) % 2], scenario.box,
                           chunks));
    const double evaluated = MillisecondsSince(start);
    const auto encoded = Checked(view->Encode(chunks, Encoding::kPatches, digests));
    const double both = MillisecondsSince(start);
    if (run < kBytesWarmUps) continue;
    whole.push_back(both);
    encode.push_back(both - evaluated);
    evaluate.push_back(evaluated);
    bytes = 0;
    for (const SharedBytes& chunk : encoded) bytes += chunk.size;
  }
  SetTime(state, MedianAndLeast(whole));
  state.counters["p99_ms"] = Quantile(whole, 0.99);
  state.counters["evaluate_ms"] = Quantile(evaluate, 0.5);
  state.counters["encode_ms"] = Quantile(encode, 0.5);
  state.counters["bytes"] = static_cast<double>(bytes);
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
                     EditToBytes(state, (*TheGpu())->backend(), model, {.edited = edited});
                   });
    }
    for (const auto& [name, its] :
         {std::pair{"tolerance-1e-4", EncodedCase{.share = 1e-4}},
          {"meshopt", EncodedCase{.encoding = Encoding::kMeshopt}},
          {"tolerance-1e-4/meshopt", EncodedCase{.share = 1e-4, .encoding = Encoding::kMeshopt}}}) {
      RegisterOnce(fmt::format("gpu/edit-to-bytes/{}-{}/all/{}", model.name, model.patches, name),
                   [model, its = its](benchmark::State& state) {
                     EditToBytes(state, (*TheGpu())->backend(), model, its);
                   });
    }
    for (const auto& [name, edited] :
         {std::pair{"all", Edited::kAll}, {"one-control-point", Edited::kMedianPoint}}) {
      RegisterOnce(
          fmt::format("gpu/edit-to-bytes/{}-{}/{}/patches", model.name, model.patches, name),
          [model, edited = edited](benchmark::State& state) {
            EditToBounds(state, (*TheGpu())->backend(), model, edited);
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
                   EditToBytes(state, *backend, model, {});
                 });
  }
  const PaperModel large = PaperModels().back();
  RegisterOnce(fmt::format("encode/edit-to-bytes/{}-{}/2t/patches", large.name, large.patches),
               [large](benchmark::State& state) {
                 const auto backend = MakeCpuBackend({.threads = 2});
                 EditToBounds(state, *backend, large, Edited::kAll);
               });
}

}  // namespace latticed::bench
