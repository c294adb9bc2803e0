// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// From Draco streams to the integers that they hold: every chunk of a deformed torus, smooth normals, 12 and 8 bits, one
// thread. libdraco skips its transforms. Ours, under each instruction set, writes the viewer's layout. Values are compared
// before they are timed. The C++ library writes the viewer's layout too, or float32 vertices, or its vectors of points.
#include <algorithm>
#include <span>
#include <string>
#include <vector>

#include "client/cpp/library/vertex_decoder.h"
#include "client/decoder/chunk_decoder.h"
#include "client/decoder/lanes/lane_kernel.h"
#include "core/codec/draco_decode.h"
#include "fmt/format.h"
#include "tests/bench/benches.h"
#include "tests/bench/scenario.h"
#include "tests/support/instruction_sets.h"

namespace latticed::bench {
namespace {

constexpr int kDecodedSegments = 10;
constexpr decoder::ChunkForm kForm{.position_bits = 12, .normal_bits = 8};
constexpr char kDecode[] = "decode/torus-17k/";

struct Update {
  std::vector<std::vector<uint8_t>> streams;
  std::vector<size_t> begins{0};  // of each chunk's points, and the end

  size_t points() const { return begins.back(); }
};

const Update& WholeUpdate() {
  static const auto* update = [] {
    const Scenario& scenario = SmallScenario(2);
    const ViewSpec spec{.segments = kDecodedSegments,
                        .normals = NormalMode::kSmooth,
                        .position_bits = kForm.position_bits,
                        .normal_bits = kForm.normal_bits};
    const auto view = MakeView(scenario, Pipeline::kFused, spec, 1);
    const auto streams = Checked(view->Encode(scenario.all_chunks, Encoding::kDracoPoints));
    auto* made = new Update;
    for (const uint32_t c : scenario.all_chunks) {
      const auto bytes = streams[c].span();
      made->streams.emplace_back(bytes.begin(), bytes.end());
      made->begins.push_back(made->begins.back() +
                             ChunkPoints(*scenario.plan, c, kDecodedSegments));
    }
    return made;
  }();
  return *update;
}

void ByLibdraco(benchmark::State& state) {
  const Update& update = WholeUpdate();
  for (auto _ : state) {
    for (const auto& stream : update.streams) {
      benchmark::DoNotOptimize(Checked(DecodeDracoChunkIntegers(stream)));
    }
  }
  CountPoints(state, update.points());
}

bool IsEqual(const DecodedIntegers& stock, const uint16_t* numbers) {
  for (size_t i = 0; i < stock.positions.size() / 3; ++i, numbers += decoder::kNumbersPerPoint) {
    for (size_t c = 0; c < 3; ++c) {
      if (numbers[c] != stock.positions[3 * i + c]) return false;
    }
    if (numbers[4] != stock.normals[2 * i] || numbers[5] != stock.normals[2 * i + 1]) return false;
  }
  return true;
}

void ByOurs(benchmark::State& state, int64_t target, size_t chunks_a_call) {
  const testing::ChosenTarget chosen(target);
  const Update& update = WholeUpdate();
  std::vector<uint16_t> numbers(decoder::kNumbersPerPoint * update.points());
  std::vector<decoder::ChunkJob> jobs;
  for (size_t i = 0; i < update.streams.size(); ++i) {
    jobs.push_back({.stream = update.streams[i],
                    .points = static_cast<uint32_t>(update.begins[i + 1] - update.begins[i]),
                    .out = &numbers[decoder::kNumbersPerPoint * update.begins[i]]});
  }
  decoder::ChunkDecoder ours;
  const auto decode = [&] {
    bool all = true;
    for (size_t first = 0; first < jobs.size(); first += chunks_a_call) {
      const size_t count = std::min(chunks_a_call, jobs.size() - first);
      all = ours.Decode(kForm, std::span(jobs).subspan(first, count)) && all;
    }
    return all;
  };
  if (!decode()) return state.SkipWithError("a stream is refused");
  for (size_t i = 0; i < jobs.size(); ++i) {
    if (IsEqual(Checked(DecodeDracoChunkIntegers(jobs[i].stream)), jobs[i].out)) continue;
    return state.SkipWithError("a stream decodes to other integers");
  }
  for (auto _ : state) benchmark::DoNotOptimize(decode());
  CountPoints(state, update.points());
}

// A call of the C++ library.
struct LibraryCase {
  const char* name;
  absl::Status (*decode)(client::VertexDecoder& decoder,
                         std::span<const client::EncodedChunk> chunks, const v1::ViewOptions& view,
                         size_t points);
};

template <class Vertex>
absl::Status ToVertices(client::VertexDecoder& decoder,
                        std::span<const client::EncodedChunk> chunks, const v1::ViewOptions& view,
                        size_t points) {
  static std::vector<Vertex> vertices;
  vertices.resize(points);
  return decoder.Decode(chunks, view, vertices);
}

absl::Status ToPoints(client::VertexDecoder& decoder, std::span<const client::EncodedChunk> chunks,
                      const v1::ViewOptions& view, size_t) {
  client::DecodedPoints points;
  return decoder.Decode(chunks, view, &points);
}

constexpr LibraryCase kLibraryCases[] = {{"grid", ToVertices<client::GridVertex>},
                                         {"world", ToVertices<client::WorldVertex>},
                                         {"points", ToPoints}};

void ByLibrary(benchmark::State& state, const LibraryCase& library) {
  const Update& update = WholeUpdate();
  v1::ViewOptions view;
  view.set_encoding(v1::ENCODING_DRACO_POINTS);
  view.set_normals(v1::NORMAL_MODE_SMOOTH);
  v1::Quantisation grid;
  grid.set_step(1);
  grid.set_bits(kForm.position_bits);
  grid.set_normal_bits(kForm.normal_bits);
  std::vector<client::EncodedChunk> chunks;
  for (size_t i = 0; i < update.streams.size(); ++i) {
    const auto& stream = update.streams[i];
    chunks.push_back({.data = {reinterpret_cast<const char*>(stream.data()), stream.size()},
                      .point_count = update.begins[i + 1] - update.begins[i],
                      .quantisation = &grid});
  }
  client::VertexDecoder decoder;
  CheckOk(library.decode(decoder, chunks, view, update.points()));
  for (auto _ : state) CheckOk(library.decode(decoder, chunks, view, update.points()));
  CountPoints(state, update.points());
}

}  // namespace

void RegisterDecodeBenches() {
  RegisterTimed(std::string(kDecode) + "libdraco", ByLibdraco);
  for (const int64_t target : testing::AllTargets()) {
    const testing::ChosenTarget chosen(target);
    RegisterTimed(fmt::format("{}latticed/{}", kDecode, decoder::lane_kernel::TargetName()),
                  [=](benchmark::State& state) { ByOurs(state, target, 16); });
  }
  for (const size_t chunks : {size_t{1}, size_t{4}, size_t{8}}) {
    RegisterTimed(
        fmt::format("{}latticed/chunks-a-call:{}", kDecode, chunks),
        [=](benchmark::State& state) { ByOurs(state, testing::Targets().front(), chunks); });
  }
  for (const LibraryCase& library : kLibraryCases) {
    RegisterTimed(fmt::format("{}library/{}", kDecode, library.name),
                  [&](benchmark::State& state) { ByLibrary(state, library); });
  }
}

}  // namespace latticed::bench
