// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// From vertices to meshopt bytes and back: every chunk of a deformed torus, smooth normals, 12 and 8 bits, one thread.
// libmeshoptimizer codes the same vertices of 12 bytes; Debian's has version 0 of the codec. What ours wrote is decoded
// and compared before it is timed. Counters: ns_point, and bytes_point of the encodings.
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include <meshoptimizer.h>

#include "client/decoder/chunk_decoder.h"
#include "client/decoder/meshopt/meshopt_kernel.h"
#include "core/codec/meshopt/meshopt_format.h"
#include "core/codec/meshopt/meshopt_kernel.h"
#include "core/codec/meshopt/meshopt_writer.h"
#include "fmt/format.h"
#include "tests/bench/benches.h"
#include "tests/bench/scenario.h"
#include "tests/support/instruction_sets.h"

namespace latticed::bench {
namespace {

using meshopt_format::kVertexBytes;

constexpr decoder::ChunkForm kMeshoptForm{
    .position_bits = 12, .normal_bits = 8, .codec = decoder::Codec::kMeshopt};
constexpr int kMeshoptSegments = 10;

struct MeshoptChunk {
  std::vector<uint8_t> integers;  // QUANTISED layout
  std::vector<uint16_t> numbers;  // vertices of kVertexBytes
  size_t points() const { return numbers.size() / decoder::kNumbersPerPoint; }
  QuantisedVertices vertices() const {
    return QuantisedVertices::FromBytes(integers, points(), kMeshoptForm.position_bits,
                                        kMeshoptForm.normal_bits);
  }
};

const std::vector<MeshoptChunk>& MeshoptChunks() {
  static const auto* chunks = [] {
    const Scenario& scenario = SmallScenario(2);
    const ViewSpec spec{.segments = kMeshoptSegments,
                        .normals = NormalMode::kSmooth,
                        .position_bits = kMeshoptForm.position_bits,
                        .normal_bits = kMeshoptForm.normal_bits};
    const auto view = MakeView(scenario, Pipeline::kFused, spec, 1);
    auto* made = new std::vector<MeshoptChunk>;
    for (const uint32_t c : scenario.all_chunks) {
      MeshoptChunk& chunk = made->emplace_back();
      chunk.integers = ReadChunk(scenario, *view, c);
      chunk.numbers.resize(decoder::kNumbersPerPoint *
                           ChunkPoints(*scenario.plan, c, kMeshoptSegments));
      const QuantisedVertices v = chunk.vertices();
      for (size_t i = 0; i < v.point_count; ++i) {
        const uint16_t numbers[] = {v.x[i], v.y[i], v.z[i], 0, v.s[i], v.t[i]};
        std::memcpy(&chunk.numbers[decoder::kNumbersPerPoint * i], numbers, sizeof(numbers));
      }
    }
    return made;
  }();
  return *chunks;
}

void CountMeshopt(benchmark::State& state, size_t bytes) {
  size_t points = 0;
  for (const MeshoptChunk& chunk : MeshoptChunks()) points += chunk.points();
  CountPoints(state, points);
  state.counters["bytes_point"] = static_cast<double>(bytes) / static_cast<double>(points);
}

std::vector<uint8_t> EncodeByLibrary(const MeshoptChunk& chunk) {
  std::vector<uint8_t> stream(meshopt_encodeVertexBufferBound(chunk.points(), kVertexBytes));
  stream.resize(meshopt_encodeVertexBuffer(stream.data(), stream.size(), chunk.numbers.data(),
                                           chunk.points(), kVertexBytes));
  return stream;
}

template <class Encode>
size_t EncodeAll(const Encode& encode) {
  size_t bytes = 0;
  for (const MeshoptChunk& chunk : MeshoptChunks()) bytes += encode(chunk).size();
  return bytes;
}

std::vector<uint8_t> EncodeByOurs(const MeshoptChunk& chunk) {
  return EncodeMeshopt(chunk.vertices());
}

void BenchEncode(benchmark::State& state, std::vector<uint8_t> (*encode)(const MeshoptChunk&)) {
  MeshoptChunks();
  size_t bytes = 0;
  for (auto _ : state) bytes = EncodeAll(encode);
  CountMeshopt(state, bytes);
}

void BenchLibraryDecode(benchmark::State& state) {
  std::vector<std::vector<uint8_t>> streams;
  size_t bytes = 0;
  for (const MeshoptChunk& chunk : MeshoptChunks())
    bytes += streams.emplace_back(EncodeByLibrary(chunk)).size();
  std::vector<uint16_t> numbers(decoder::kNumbersPerPoint * decoder::kMostPoints);
  for (auto _ : state) {
    for (size_t i = 0; i < streams.size(); ++i) {
      benchmark::DoNotOptimize(meshopt_decodeVertexBuffer(numbers.data(),
                                                          MeshoptChunks()[i].points(), kVertexBytes,
                                                          streams[i].data(), streams[i].size()));
    }
  }
  CountMeshopt(state, bytes);
}

void BenchDecode(benchmark::State& state) {
  std::vector<std::vector<uint8_t>> streams;
  size_t bytes = 0;
  for (const MeshoptChunk& chunk : MeshoptChunks())
    bytes += streams.emplace_back(EncodeByOurs(chunk)).size();
  std::vector<uint16_t> numbers(decoder::kNumbersPerPoint * decoder::kMostPoints);
  decoder::ChunkDecoder ours;
  const auto decode = [&](size_t i) {
    decoder::ChunkJob job{.stream = streams[i],
                          .points = static_cast<uint32_t>(MeshoptChunks()[i].points()),
                          .out = numbers.data()};
    return ours.Decode(kMeshoptForm, {&job, 1});
  };
  for (size_t i = 0; i < streams.size(); ++i) {
    const std::vector<uint16_t>& expected = MeshoptChunks()[i].numbers;
    if (decode(i) && std::equal(expected.begin(), expected.end(), numbers.begin())) continue;
    return state.SkipWithError("a stream is refused, or decodes to other integers");
  }
  for (auto _ : state) {
    for (size_t i = 0; i < streams.size(); ++i) benchmark::DoNotOptimize(decode(i));
  }
  CountMeshopt(state, bytes);
}

}  // namespace

void RegisterMeshoptBenches() {
  RegisterTimed("meshopt/encode/libmeshoptimizer",
                [](benchmark::State& state) { BenchEncode(state, EncodeByLibrary); });
  RegisterTimed("meshopt/decode/libmeshoptimizer", BenchLibraryDecode);
  for (const int64_t target : testing::AllTargets()) {
    const auto under_target = [target](auto bench) {
      return [=](benchmark::State& state) {
        const testing::ChosenTarget chosen(target);
        bench(state);
      };
    };
    const testing::ChosenTarget chosen(target);
    RegisterTimed(fmt::format("meshopt/encode/latticed/{}", meshopt_kernel::TargetName()),
                  under_target([](benchmark::State& state) { BenchEncode(state, EncodeByOurs); }));
    RegisterTimed(fmt::format("meshopt/decode/latticed/{}", decoder::meshopt_kernel::TargetName()),
                  under_target(BenchDecode));
  }
}

}  // namespace latticed::bench
