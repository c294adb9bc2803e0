// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// From vertices to Draco streams, every chunk of a deformed torus, smooth normals, 12 and 8 bits, one
// thread: libdraco beside our writer, from floats and from integers, under each instruction set.
// All streams are decoded and compared before any is timed.
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "core/base/status_macros.h"
#include "core/codec/draco_decode.h"
#include "core/codec/draco_geometry.h"
#include "core/codec/draco_kernel.h"
#include "core/codec/octahedral.h"
#include "fmt/format.h"
#include "tests/bench/benches.h"
#include "tests/bench/codec/quantise_vertices.h"
#include "tests/bench/codec/row_order.h"
#include "tests/bench/scenario.h"
#include "tests/support/instruction_sets.h"

namespace latticed::bench {
namespace {

constexpr int kSegments = 10, kPositionBits = 12, kNormalBits = 8;
constexpr double kRange = 8;
constexpr char kScenario[] = "codec/torus-17k/";

using Streams = std::vector<std::vector<uint8_t>>;

struct ChunkData {
  size_t points = 0;
  std::vector<uint8_t> integers;  // QUANTISED layout
  std::vector<float> floats;      // RAW layout, positions in grid units
  DracoGeometry geometry;         // the same as libdraco takes it

  QuantisedVertices vertices() const {
    return QuantisedVertices::FromBytes(integers, points, kPositionBits, kNormalBits);
  }
};

ChunkData MakeChunk(size_t points, std::vector<uint8_t> integers) {
  ChunkData chunk{.points = points, .integers = std::move(integers)};
  const QuantisedVertices v = chunk.vertices();
  DracoGeometry& g = chunk.geometry;
  g = {.point_count = points,
       .position_bits = kPositionBits,
       .normal_bits = kNormalBits,
       .range = static_cast<float>(kRange)};
  for (size_t i = 0; i < points; ++i) {
    const Vec3f n = DequantiseNormal({v.s[i], v.t[i]}, kNormalBits);
    const std::array<float, 6> values{static_cast<float>(v.x[i]),
                                      static_cast<float>(v.y[i]),
                                      static_cast<float>(v.z[i]),
                                      n.x,
                                      n.y,
                                      n.z};
    chunk.floats.insert(chunk.floats.end(), values.begin(), values.end());
    g.grid_positions.insert(g.grid_positions.end(), values.begin(), values.begin() + 3);
    g.normals.insert(g.normals.end(), values.begin() + 3, values.end());
  }
  return chunk;
}

const std::vector<ChunkData>& Chunks(bool row_by_row) {
  static const auto* chunks = [] {
    const Scenario& scenario = SmallScenario(2);
    const ViewSpec spec{.segments = kSegments,
                        .normals = NormalMode::kSmooth,
                        .position_bits = kPositionBits,
                        .normal_bits = kNormalBits};
    const auto view = MakeView(scenario, Pipeline::kFused, spec, 1);
    auto* both = new std::array<std::vector<ChunkData>, 2>;
    for (const uint32_t c : scenario.all_chunks) {
      const size_t points = ChunkPoints(*scenario.plan, c, kSegments);
      std::vector<uint8_t> bytes(points * BytesPerPoint(spec));
      CheckOk(view->Read(c, bytes));
      (*both)[1].push_back(MakeChunk(points, RowByRow(bytes, spec)));
      (*both)[0].push_back(MakeChunk(points, std::move(bytes)));
    }
    return both;
  }();
  return (*chunks)[row_by_row ? 1 : 0];
}

absl::Status Verify(const std::vector<ChunkData>& chunks, const Streams& streams) {
  for (size_t i = 0; i < chunks.size(); ++i) {
    LATTICED_ASSIGN_OR_RETURN(const auto decoded, DecodeDracoChunkIntegers(streams[i]));
    const QuantisedVertices v = chunks[i].vertices();
    for (size_t p = 0; p < v.point_count; ++p) {
      const uint32_t* position = &decoded.positions[3 * p];
      const uint32_t* normal = &decoded.normals[2 * p];
      if (position[0] != v.x[p] || position[1] != v.y[p] || position[2] != v.z[p] ||
          normal[0] != v.s[p] || normal[1] != v.t[p]) {
        return absl::InternalError(fmt::format("chunk {} decodes to other integers", i));
      }
    }
  }
  return absl::OkStatus();
}

// `encode` fills the streams of all chunks.
template <class Encode>
void Measure(benchmark::State& state, const std::vector<ChunkData>& chunks, const Encode& encode) {
  Streams streams(chunks.size());
  encode(streams);
  if (const absl::Status verified = Verify(chunks, streams); !verified.ok()) {
    state.SkipWithError(std::string(verified.message()).c_str());
    return;
  }
  for (auto _ : state) {
    streams.assign(chunks.size(), {});  // as in a server, which keeps the ones before
    encode(streams);
  }
  size_t points = 0, bytes = 0;
  for (const ChunkData& chunk : chunks) points += chunk.points;
  for (const auto& stream : streams) bytes += stream.size();
  state.counters["ns_point"] = benchmark::Counter(
      static_cast<double>(points) * 1e-9,
      benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  state.counters["bytes_point"] = static_cast<double>(bytes) / static_cast<double>(points);
}

void Libdraco(benchmark::State& state) {
  const std::vector<ChunkData>& chunks = Chunks(false);
  Measure(state, chunks, [&](Streams& streams) {
    for (size_t i = 0; i < chunks.size(); ++i) {
      auto stream = EncodeDraco(chunks[i].geometry, std::nullopt);
      CheckOk(stream.status());
      streams[i] = *std::move(stream);
    }
  });
}

struct WriterCase {
  int64_t target;
  bool floats = false, row_by_row = false;
};

void Writer(benchmark::State& state, const WriterCase& c) {
  const testing::ChosenTarget chosen(c.target);
  const std::vector<ChunkData>& chunks = Chunks(c.row_by_row);
  const auto encoder = MakeChunkEncoder("latticed");
  std::vector<std::vector<uint8_t>> quantised(encoder->batch());
  Measure(state, chunks, [&](Streams& streams) {
    std::vector<QuantisedVertices> batch;
    for (size_t first = 0; first < chunks.size(); first += encoder->batch()) {
      const size_t count = std::min(encoder->batch(), chunks.size() - first);
      batch.clear();
      for (size_t i = 0; i < count; ++i) {
        const ChunkData& chunk = chunks[first + i];
        quantised[i].resize(10 * chunk.points);
        batch.push_back(c.floats ? QuantiseVertices({.point_count = chunk.points,
                                                     .values = chunk.floats.data(),
                                                     .position_bits = kPositionBits,
                                                     .normal_bits = kNormalBits},
                                                    quantised[i].data())
                                 : chunk.vertices());
      }
      CheckOk(encoder->Encode(batch, kRange, nullptr, std::span(streams).subspan(first, count)));
    }
  });
}

// Through a view: the backend's threads, and bytes handed on.
void View(benchmark::State& state, int threads) {
  const Scenario& scenario = SmallScenario(2);
  const ViewSpec spec{.normals = NormalMode::kSmooth};
  const auto view = MakeView(scenario, Pipeline::kFused, spec, threads);
  for (auto _ : state) {
    CheckOk(view->Encode(scenario.all_chunks, Encoding::kDracoPoints).status());
  }
}

}  // namespace

void RegisterCodecBenches() {
  RegisterTimed(std::string(kScenario) + "libdraco", Libdraco);
  for (const int64_t target : testing::Targets()) {
    const testing::ChosenTarget chosen(target);
    const std::string name = fmt::format("{}latticed/{}/", kScenario, draco_kernel::TargetName());
    for (const bool floats : {false, true}) {
      RegisterTimed(name + (floats ? "floats" : "integers"), [=](benchmark::State& state) {
        Writer(state, {.target = target, .floats = floats});
      });
    }
  }
  const int64_t best = testing::Targets().front();
  RegisterTimed(std::string(kScenario) + "latticed/row-order", [=](benchmark::State& state) {
    Writer(state, {.target = best, .row_by_row = true});
  });
  for (const int threads : {1, 2}) {
    RegisterTimed(fmt::format("encode/torus-17k/draco-points/{}t", threads),
                  [=](benchmark::State& state) { View(state, threads); });
  }
}

}  // namespace latticed::bench
