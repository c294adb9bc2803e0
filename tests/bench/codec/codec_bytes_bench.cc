// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Bytes of whole updates at 10 segments: of our writer, of libdraco on the same points in the same
// order, and of our writer row by row, for two samples and five models under a jittered lattice.
// Every stream that is compared with libdraco's is decoded. Counters:
//
//   bytes_point, libdraco_bytes_point  over all chunks
//   percent                            how many more bytes ours take
//   chunks, larger, larger_bytes       all; those where ours takes more, and how much more there
//   tagged_chunks                      where libdraco picks its tagged scheme for an attribute
//   more_at_tagged, more_elsewhere     how many more bytes ours take in those, and in the others
//   row_by_row_bytes_point             of ours on the points row by row
//   serpentine_saves_percent           of these
#include <utility>

#include "fmt/format.h"
#include "tests/bench/benches.h"
#include "tests/bench/codec/codec_bytes.h"
#include "tests/bench/model_scenarios.h"

namespace latticed::bench {
namespace {

constexpr int kSegments = 10;

void Compare(benchmark::State& state, const std::string& model, const ViewSpec& spec) {
  absl::StatusOr<CodecBytes> bytes;
  for (auto _ : state) bytes = CodecBytes::Count(ModelScenario(model), spec);
  if (!bytes.ok()) {
    state.SkipWithError(std::string(bytes.status().message()).c_str());
    return;
  }
  const auto a_point = [&](size_t sum) {
    return static_cast<double>(sum) / static_cast<double>(bytes->points);
  };
  state.counters["bytes_point"] = a_point(bytes->ours);
  state.counters["libdraco_bytes_point"] = a_point(bytes->libdraco);
  state.counters["percent"] = 100 * bytes->more_than_libdraco();
  state.counters["chunks"] = static_cast<double>(bytes->chunks);
  state.counters["larger"] = static_cast<double>(bytes->larger);
  state.counters["larger_bytes"] = static_cast<double>(bytes->larger_bytes);
  state.counters["tagged_chunks"] = static_cast<double>(bytes->tagged_chunks);
  state.counters["more_at_tagged"] = static_cast<double>(bytes->more_at_tagged);
  state.counters["more_elsewhere"] = static_cast<double>(bytes->more_elsewhere);
  state.counters["row_by_row_bytes_point"] = a_point(bytes->row_by_row);
  state.counters["serpentine_saves_percent"] = 100 * bytes->saved_by_serpentine();
}

void RegisterModel(const std::string& model) {
  for (const auto& [normals, name] :
       {std::pair{NormalMode::kFacet, "facet"}, {NormalMode::kSmooth, "smooth"}}) {
    for (const auto& [position_bits, normal_bits] :
         {std::pair{11, 8}, {12, 8}, {14, 10}, {16, 12}}) {
      const ViewSpec spec{.segments = kSegments,
                          .normals = normals,
                          .position_bits = position_bits,
                          .normal_bits = normal_bits};
      benchmark::RegisterBenchmark(
          fmt::format("codec/bytes/{}/{}/{}-{}", model, name, position_bits, normal_bits).c_str(),
          [=](benchmark::State& state) { Compare(state, model, spec); })
          ->Iterations(1)
          ->Unit(benchmark::kMillisecond);
    }
  }
}

}  // namespace

void RegisterCodecBytesBenches() {
  for (const char* model : kModelNames) {
    if (HasModel(model)) RegisterModel(model);
  }
}

}  // namespace latticed::bench
