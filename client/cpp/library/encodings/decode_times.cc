// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/library/encodings/decode_times.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <vector>

#include "client/decoder/chunk_decoder.h"
#include "core/codec/draco_writer.h"
#include "core/codec/meshopt/meshopt_writer.h"
#include "core/codec/octahedral.h"

namespace latticed::client {
namespace {

// Chunks of patches of 10 segments, in the bits that views have by default.
constexpr int kSampleChunks = 8, kSamplePatches = 16, kSampleSegments = 10;
constexpr size_t kChunkPoints =
    kSamplePatches * (kSampleSegments + 1) * (kSampleSegments + 2) / 2;  // of a chunk
constexpr decoder::ChunkForm kSampleForm{.position_bits = 12, .normal_bits = 8};
constexpr int kDecodeRuns = 5;  // the shortest counts

using Streams = std::array<std::vector<uint8_t>, kSampleChunks>;

struct SampleChunk {
  std::vector<uint16_t> x, y, z;
  std::vector<uint8_t> s, t;

  void Append(Vec3d unit, Vec3d normal) {  // coordinates -1 to 1
    const auto integer = [](double value) {
      return static_cast<uint16_t>(
          std::lround((value + 1) / 2 * ((1 << kSampleForm.position_bits) - 1)));
    };
    x.push_back(integer(unit.x)), y.push_back(integer(unit.y)), z.push_back(integer(unit.z));
    const OctahedralNormal n = QuantiseNormal({float(normal.x), float(normal.y), float(normal.z)},
                                              kSampleForm.normal_bits);
    s.push_back(static_cast<uint8_t>(n.s)), t.push_back(static_cast<uint8_t>(n.t));
  }

  QuantisedVertices vertices() const {
    return {.point_count = x.size(),
            .position_bits = kSampleForm.position_bits,
            .normal_bits = kSampleForm.normal_bits,
            .x = x.data(),
            .y = y.data(),
            .z = z.data(),
            .s = s.data(),
            .t = t.data()};
  }
};

// A part of a torus with 120 patches around its ring and its tube: 1.7 bytes a point of Draco, as of meshes.
SampleChunk Sample(int chunk) {
  constexpr double kRing = 0.7, kTube = 0.25, kTurn = 2 * std::numbers::pi / 120;
  SampleChunk sample;
  for (int patch = 0; patch < kSamplePatches; ++patch) {
    for (int i = 0; i <= kSampleSegments; ++i) {
      for (int j = 0; j <= kSampleSegments - i; ++j) {
        const double u = kTurn * (chunk + double(i) / kSampleSegments);
        const double v = kTurn * (patch + double(j) / kSampleSegments);
        const Vec3d normal{std::cos(u) * std::cos(v), std::sin(u) * std::cos(v), std::sin(v)};
        sample.Append(Vec3d{std::cos(u), std::sin(u), 0} * kRing + normal * kTube, normal);
      }
    }
  }
  return sample;
}

// Seconds a point.
double DecodeTime(const Streams& streams, decoder::Codec codec) {
  using Clock = std::chrono::steady_clock;
  decoder::ChunkForm form = kSampleForm;
  form.codec = codec;
  std::vector<uint16_t> numbers(kSampleChunks * kChunkPoints * decoder::kNumbersPerPoint);
  decoder::ChunkDecoder decoder;
  double shortest = std::numeric_limits<double>::infinity();
  for (int run = 0; run < kDecodeRuns; ++run) {
    std::array<decoder::ChunkJob, kSampleChunks> jobs;
    for (size_t i = 0; i < kSampleChunks; ++i) {
      jobs[i] = {.stream = streams[i],
                 .points = kChunkPoints,
                 .out = numbers.data() + i * kChunkPoints * decoder::kNumbersPerPoint};
    }
    const auto begin = Clock::now();
    (void)decoder.Decode(form, jobs);
    shortest = std::min(shortest, std::chrono::duration<double>(Clock::now() - begin).count());
  }
  return shortest / (kSampleChunks * kChunkPoints);
}

DecodeTimes Measure() {
  std::array<SampleChunk, kSampleChunks> samples;
  std::array<QuantisedVertices, kSampleChunks> chunks;
  for (size_t i = 0; i < kSampleChunks; ++i) samples[i] = Sample(static_cast<int>(i));
  std::ranges::transform(samples, chunks.begin(), &SampleChunk::vertices);
  Streams draco, meshopt;
  (void)DracoWriter().Encode(chunks, /*range=*/2, /*connectivity=*/nullptr, draco);
  std::ranges::transform(chunks, meshopt.begin(), EncodeMeshopt);
  return {DecodeTime(draco, decoder::Codec::kDraco), DecodeTime(meshopt, decoder::Codec::kMeshopt)};
}

}  // namespace

const DecodeTimes& MeasuredDecodeTimes() {
  static const DecodeTimes times = Measure();
  return times;
}

}  // namespace latticed::client
