// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Fuzzes the clients' decoder of meshopt chunks. All instruction sets must agree, and one of them is plain C++ without
// vectors. What is accepted, written again and decoded again has the same numbers. Nothing is written beside a chunk's slice.
//
//   input   position bits; normal bits; two bytes of points; then the stream
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "client/decoder/chunk_decoder.h"
#include "core/codec/meshopt/meshopt_writer.h"
#include "tests/support/instruction_sets.h"

namespace latticed {
namespace {

using decoder::ChunkForm;
using decoder::ChunkJob;
using decoder::kNumbersPerPoint;

constexpr size_t kHead = 4;
constexpr uint32_t kMostPoints = 1024;  // for speed
constexpr size_t kGuard = 8;
constexpr uint16_t kUntouched = 0xA55A;

void Require(bool holds) {
  if (!holds) std::abort();
}

// The numbers of the points, none if the stream is refused.
std::vector<uint16_t> Decode(const ChunkForm& form, uint32_t points,
                             std::span<const uint8_t> stream) {
  std::vector<uint16_t> numbers(kNumbersPerPoint * points + kGuard, kUntouched);
  ChunkJob job{.stream = stream, .points = points, .out = numbers.data()};
  static decoder::ChunkDecoder ours;  // keeps nothing between meshopt chunks
  ours.Decode(form, {&job, 1});
  Require(std::all_of(numbers.end() - kGuard, numbers.end(),
                      [](uint16_t n) { return n == kUntouched; }));
  numbers.resize(job.decoded ? numbers.size() - kGuard : 0);
  return numbers;
}

std::vector<uint8_t> Encode(const ChunkForm& form, uint32_t points,
                            const std::vector<uint16_t>& numbers) {
  std::vector<uint16_t> planes[kNumbersPerPoint];
  for (size_t i = 0; i < numbers.size(); ++i) {
    planes[i % kNumbersPerPoint].push_back(numbers[i]);
  }
  const auto bytes_of = [&](const std::vector<uint16_t>& plane) {
    const auto* const bytes = reinterpret_cast<const uint8_t*>(plane.data());
    return form.normal_bits > 8 ? std::vector<uint8_t>(bytes, bytes + 2 * points)
                                : std::vector<uint8_t>(plane.begin(), plane.end());
  };
  const std::vector<uint8_t> s = bytes_of(planes[4]), t = bytes_of(planes[5]);
  return EncodeMeshopt({.point_count = points,
                        .position_bits = form.position_bits,
                        .normal_bits = form.normal_bits,
                        .x = planes[0].data(),
                        .y = planes[1].data(),
                        .z = planes[2].data(),
                        .s = form.normal_bits > 0 ? s.data() : nullptr,
                        .t = form.normal_bits > 0 ? t.data() : nullptr});
}

void Check(const ChunkForm& form, uint32_t points, std::span<const uint8_t> stream) {
  static const std::vector<int64_t> targets = testing::AllTargets();
  const std::vector<uint16_t> numbers = Decode(form, points, stream);
  for (const int64_t target : targets) {
    const testing::ChosenTarget chosen(target);
    Require(Decode(form, points, stream) == numbers);
  }
  if (!numbers.empty()) Require(Decode(form, points, Encode(form, points, numbers)) == numbers);
}

}  // namespace
}  // namespace latticed

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using latticed::kHead;
  if (size < kHead) return 0;
  const latticed::decoder::ChunkForm form{.position_bits = data[0],
                                          .normal_bits = data[1],
                                          .codec = latticed::decoder::Codec::kMeshopt};
  const uint32_t points = (data[2] | uint32_t{data[3]} << 8) % (latticed::kMostPoints + 1);
  latticed::Check(form, points, {data + kHead, size - kHead});
  return 0;
}
