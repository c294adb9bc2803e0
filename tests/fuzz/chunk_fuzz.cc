// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Fuzzes the clients' decoder of chunks. What it accepts, libdraco must decode to the same
// integers, in whatever lane the chunk lies; nothing is written beside a chunk's slice.
//
//   input   position bits; normal bits, and the instruction set in the upper half; two bytes of points; then the stream
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "client/decoder/chunk_decoder.h"
#include "core/codec/draco_decode.h"
#include "tests/support/instruction_sets.h"

namespace latticed {
namespace {

using decoder::ChunkForm;
using decoder::ChunkJob;
using decoder::kNumbersPerPoint;

constexpr size_t kHead = 4;
constexpr size_t kCopies = 13;        // of the chunk: eight in lockstep, four, and one alone
constexpr size_t kMostPoints = 1024;  // for speed
constexpr size_t kGuard = 8;
constexpr uint16_t kUntouched = 0xA5A5;

void Require(bool holds) {
  if (!holds) std::abort();
}

void RequireIntegers(const uint16_t* numbers, size_t points, const DecodedIntegers& stock) {
  Require(stock.positions.size() == 3 * points);
  for (size_t i = 0; i < points; ++i, numbers += kNumbersPerPoint) {
    for (size_t c = 0; c < 3; ++c) Require(numbers[c] == stock.positions[3 * i + c]);
    Require(numbers[3] == 0);
    for (size_t c = 0; c < 2; ++c) {
      Require(numbers[4 + c] == (stock.normals.empty() ? 0 : stock.normals[2 * i + c]));
    }
  }
}

void Check(const ChunkForm& form, size_t points, std::span<const uint8_t> stream) {
  const size_t slice = kNumbersPerPoint * points + kGuard;
  // Fresh memory for every run would take half of the time.
  static std::vector<uint16_t> numbers(kCopies * (kNumbersPerPoint * kMostPoints + kGuard));
  static decoder::ChunkDecoder ours;
  std::memset(numbers.data(), kUntouched & 0xFF, kCopies * slice * sizeof(uint16_t));
  std::array<ChunkJob, kCopies> jobs;
  for (size_t k = 0; k < kCopies; ++k) {
    jobs[k] = {.stream = stream,
               .points = static_cast<uint32_t>(points),
               .out = numbers.data() + k * slice};
  }
  ours.Decode(form, jobs);
  for (size_t k = 0; k < kCopies; ++k) {
    const uint16_t* const guard = jobs[k].out + kNumbersPerPoint * points;
    Require(std::all_of(guard, guard + kGuard, [](uint16_t n) { return n == kUntouched; }));
    Require(jobs[k].decoded == jobs[0].decoded);
  }
  if (!jobs[0].decoded) return;
  const auto stock = DecodeDracoChunkIntegers(stream);
  Require(stock.ok());
  for (const ChunkJob& job : jobs) RequireIntegers(job.out, points, *stock);
}

}  // namespace
}  // namespace latticed

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using latticed::kHead;
  if (size < kHead) return 0;
  static const std::vector<int64_t> targets = latticed::testing::AllTargets();
  const latticed::testing::ChosenTarget chosen(targets[(data[1] >> 4) % targets.size()]);
  const latticed::decoder::ChunkForm form{.position_bits = data[0], .normal_bits = data[1] & 15};
  const size_t points = (data[2] | size_t{data[3]} << 8) % (latticed::kMostPoints + 1);
  latticed::Check(form, points, {data + kHead, size - kHead});
  return 0;
}
