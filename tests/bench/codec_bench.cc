// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// From quantised vertices to Draco streams, every chunk of a deformed torus; verified by decoding.
#include <cstring>
#include <string>
#include <vector>

#include "core/codec/draco_decode.h"
#include "tests/bench/benches.h"
#include "tests/bench/scenario.h"

namespace latticed::bench {
namespace {

// The decoded integers must be the view's own. Draco may write a rim normal by another of its
// names, so positions are compared.
absl::Status VerifyStream(const Scenario& scenario, DeformView& view, const SharedBytes& stream) {
  const size_t count = ChunkPoints(*scenario.plan, 0, view.spec().segments);
  std::vector<uint8_t> bytes(count * BytesPerPoint(view.spec()));
  CheckOk(view.Read(0, bytes));
  const auto decoded = DecodeDracoChunkIntegers(stream.span());
  CheckOk(decoded.status());
  if (decoded->positions.size() != 3 * count)
    return absl::InternalError("another number of points");
  for (size_t axis = 0; axis < 3; ++axis) {
    for (size_t i = 0; i < count; ++i) {
      uint16_t value = 0;
      std::memcpy(&value, bytes.data() + 2 * (axis * count + i), sizeof(value));
      if (decoded->positions[3 * i + axis] != value) return absl::InternalError("another position");
    }
  }
  return absl::OkStatus();
}

void Encode(benchmark::State& state) {
  const Scenario& scenario = SmallScenario(2);
  const auto view = MakeView(scenario, Pipeline::kFused, ViewSpec{}, 1);
  const auto first = view->Encode({{0u}}, Encoding::kDracoPoints);
  CheckOk(first.status());
  if (const auto verified = VerifyStream(scenario, *view, first->front()); !verified.ok()) {
    state.SkipWithError(std::string(verified.message()).c_str());
    return;
  }
  size_t bytes = 0;
  for (auto _ : state) {
    const auto streams = view->Encode(scenario.all_chunks, Encoding::kDracoPoints);
    CheckOk(streams.status());
    bytes = 0;
    for (const SharedBytes& stream : *streams) bytes += stream.size;
  }
  const auto points = static_cast<double>(scenario.points(view->spec().segments));
  state.counters["ns_point"] = benchmark::Counter(
      points * 1e-9, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  state.counters["bytes_point"] = static_cast<double>(bytes) / points;
}

}  // namespace

void RegisterCodecBenches() { RegisterTimed("encode/torus-17k/draco-points/reference/1t", Encode); }

}  // namespace latticed::bench
