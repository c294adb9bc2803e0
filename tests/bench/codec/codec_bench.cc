// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// From vertices to Draco streams: every chunk of a deformed torus, smooth normals, 12 and 8 bits,
// one thread. libdraco is compared with our writer, from floats and from integers, under each
// instruction set. All streams are decoded and compared before they are timed.
//
// Then the bytes of whole updates, for two samples and five models under a jittered lattice. Counters:
//
//   bytes_point               bytes per point over all chunks, by our writer
//   libdraco_bytes_point      the same by libdraco, for the same points in the same order
//   percent                   how much more than libdraco our writer takes
//   row_by_row_bytes_point    by our writer, with the points row by row
//   serpentine_saves_percent  how much less than row by row our order takes
#include <algorithm>
#include <array>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "core/codec/draco_geometry.h"
#include "core/codec/draco_kernel.h"
#include "core/codec/octahedral.h"
#include "core/ffd/tessellation_pattern.h"
#include "fmt/format.h"
#include "tests/bench/benches.h"
#include "tests/bench/codec/quantise_vertices.h"
#include "tests/bench/model_scenarios.h"
#include "tests/bench/scenario.h"
#include "tests/support/encode_chunk.h"
#include "tests/support/holds_integers.h"
#include "tests/support/instruction_sets.h"

namespace latticed::bench {
namespace {

constexpr int kCodecSegments = 10, kPositionBits = 12, kNormalBits = 8;
constexpr double kRange = 8;
constexpr char kScenario[] = "codec/torus-17k/";

using Streams = std::vector<std::vector<uint8_t>>;

struct ChunkData {
  size_t points = 0;
  std::vector<uint8_t> integers;  // QUANTISED layout
  std::vector<float> floats;      // RAW layout, positions in grid units
  DracoGeometry geometry;         // the same vertices in libdraco's form

  QuantisedVertices vertices() const {
    return QuantisedVertices::FromBytes(integers, points, kPositionBits, kNormalBits);
  }
};

QuantisedVertices VerticesOf(std::span<const uint8_t> chunk, const ViewSpec& spec) {
  return QuantisedVertices::FromBytes(chunk, chunk.size() / BytesPerPoint(spec), spec.position_bits,
                                      spec.normal_bits);
}

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

// `integers` are whole patches in the QUANTISED layout of `spec`. Returns them with every row of a
// patch running from corner 0 to corner 1, the order that the serpentine one is measured against.
std::vector<uint8_t> RowByRow(std::span<const uint8_t> integers, const ViewSpec& spec) {
  std::vector<size_t> from;  // index by place in a patch
  for (int row = 0; row <= spec.segments; ++row) {
    for (int column = 0; column <= spec.segments - row; ++column) {
      from.push_back(static_cast<size_t>(PointIndex(spec.segments, row, column)));
    }
  }
  const size_t points = integers.size() / BytesPerPoint(spec);
  std::vector<uint8_t> rows(integers.size());
  size_t begin = 0;
  const size_t normal_width = spec.normal_bits <= 8 ? 1 : 2;
  for (const size_t width : {size_t{2}, size_t{2}, size_t{2}, normal_width, normal_width}) {
    for (size_t i = 0; i < points; ++i) {
      const size_t in_patch = i % from.size();
      std::memcpy(&rows[begin + width * i],
                  &integers[begin + width * (i - in_patch + from[in_patch])], width);
    }
    begin += width * points;
  }
  return rows;
}

const std::vector<ChunkData>& Chunks(bool row_by_row) {
  static const auto* chunks = [] {
    const Scenario& scenario = SmallScenario(2);
    const ViewSpec spec{.segments = kCodecSegments,
                        .normals = NormalMode::kSmooth,
                        .position_bits = kPositionBits,
                        .normal_bits = kNormalBits};
    const auto view = MakeView(scenario, Pipeline::kFused, spec, 1);
    auto* both = new std::array<std::vector<ChunkData>, 2>;
    for (const uint32_t c : scenario.all_chunks) {
      const size_t points = ChunkPoints(*scenario.plan, c, kCodecSegments);
      std::vector<uint8_t> bytes = ReadChunk(scenario, *view, c);
      (*both)[1].push_back(MakeChunk(points, RowByRow(bytes, spec)));
      (*both)[0].push_back(MakeChunk(points, std::move(bytes)));
    }
    return both;
  }();
  return (*chunks)[row_by_row ? 1 : 0];
}

// `encode` fills the streams of all chunks. They are checked before it is timed.
template <class Encode>
void Measure(benchmark::State& state, const std::vector<ChunkData>& chunks, const Encode& encode) {
  Streams streams(chunks.size());
  encode(streams);
  for (size_t i = 0; i < chunks.size(); ++i) {
    if (testing::HoldsIntegers(streams[i], chunks[i].vertices())) continue;
    return state.SkipWithError("a stream decodes to other integers");
  }
  for (auto _ : state) {
    streams.assign(chunks.size(), {});  // new memory, because a server keeps older streams
    encode(streams);
  }
  size_t points = 0, bytes = 0;
  for (const ChunkData& chunk : chunks) points += chunk.points;
  for (const auto& stream : streams) bytes += stream.size();
  CountPoints(state, points);
  state.counters["bytes_point"] = static_cast<double>(bytes) / static_cast<double>(points);
}

void Libdraco(benchmark::State& state) {
  const std::vector<ChunkData>& chunks = Chunks(false);
  Measure(state, chunks, [&](Streams& streams) {
    for (size_t i = 0; i < chunks.size(); ++i) {
      streams[i] = Checked(EncodeDraco(chunks[i].geometry, std::nullopt));
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

// Through a view: includes the backend's threads and handing the bytes on.
void View(benchmark::State& state, int threads) {
  const Scenario& scenario = SmallScenario(2);
  const ViewSpec spec{.normals = NormalMode::kSmooth};
  const auto view = MakeView(scenario, Pipeline::kFused, spec, threads);
  for (auto _ : state) {
    CheckOk(view->Encode(scenario.all_chunks, Encoding::kDracoPoints).status());
  }
}

// The streams of all chunks by our writer, in groups of its batch size, as backends encode them.
Streams Written(const Scenario& scenario, const ViewSpec& spec, const Streams& chunks) {
  const auto writer = MakeChunkEncoder("latticed");
  Streams streams(chunks.size());
  for (size_t first = 0; first < chunks.size(); first += writer->batch()) {
    const size_t count = std::min(writer->batch(), chunks.size() - first);
    std::vector<QuantisedVertices> group;
    for (size_t i = first; i < first + count; ++i) group.push_back(VerticesOf(chunks[i], spec));
    CheckOk(writer->Encode(group, scenario.box.range, nullptr,
                           std::span(streams).subspan(first, count)));
  }
  return streams;
}

size_t BytesOf(const Streams& streams) {
  size_t bytes = 0;
  for (const auto& stream : streams) bytes += stream.size();
  return bytes;
}

void CompareBytes(benchmark::State& state, const std::string& model, const ViewSpec& spec) {
  const Scenario& scenario = ModelScenario(model);
  const auto view = MakeView(scenario, Pipeline::kFused, spec, 1);
  const auto reference = MakeReferenceEncoder();
  Streams chunks, rows, theirs;
  for (const uint32_t c : scenario.all_chunks) {
    chunks.push_back(ReadChunk(scenario, *view, c));
    rows.push_back(RowByRow(chunks.back(), spec));
    theirs.push_back(Checked(
        testing::EncodePoints(*reference, VerticesOf(chunks.back(), spec), scenario.box.range)));
  }
  Streams streams;
  for (auto _ : state) streams = Written(scenario, spec, chunks);
  for (size_t i = 0; i < chunks.size(); ++i) {
    if (testing::HoldsIntegers(streams[i], VerticesOf(chunks[i], spec))) continue;
    return state.SkipWithError("a stream decodes to other integers");
  }
  const auto points = static_cast<double>(BytesOf(chunks) / BytesPerPoint(spec));
  const auto ours = static_cast<double>(BytesOf(streams));
  const auto libdraco = static_cast<double>(BytesOf(theirs));
  const auto row_by_row = static_cast<double>(BytesOf(Written(scenario, spec, rows)));
  state.counters["bytes_point"] = ours / points;
  state.counters["libdraco_bytes_point"] = libdraco / points;
  state.counters["percent"] = 100 * (ours / libdraco - 1);
  state.counters["row_by_row_bytes_point"] = row_by_row / points;
  state.counters["serpentine_saves_percent"] = 100 * (1 - ours / row_by_row);
}

void RegisterModel(const std::string& model) {
  for (const auto& [normals, name] :
       {std::pair{NormalMode::kFacet, "facet"}, {NormalMode::kSmooth, "smooth"}}) {
    for (const auto& [position_bits, normal_bits] :
         {std::pair{11, 8}, {12, 8}, {14, 10}, {16, 12}}) {
      const ViewSpec spec{.segments = kCodecSegments,
                          .normals = normals,
                          .position_bits = position_bits,
                          .normal_bits = normal_bits};
      benchmark::RegisterBenchmark(
          fmt::format("codec/bytes/{}/{}/{}-{}", model, name, position_bits, normal_bits).c_str(),
          [=](benchmark::State& state) { CompareBytes(state, model, spec); })
          ->Iterations(1)
          ->Unit(benchmark::kMillisecond);
    }
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
  for (const char* model : kModelNames) {
    if (HasModel(model)) RegisterModel(model);
  }
}

}  // namespace latticed::bench
