// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A fixture for tests of coders on the device: chunks for them, and a device to write their streams.
#ifndef LATTICED_TESTS_CUDA_STREAMS_STREAM_CODER_TEST_H_
#define LATTICED_TESTS_CUDA_STREAMS_STREAM_CODER_TEST_H_

#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "cuda/streams/device_stream_writer.h"
#include "tests/core/codec/chunk_fixtures.h"
#include "tests/cuda/cuda_test.h"

namespace latticed::testing {

class StreamCoderTest : public CudaTest {
 protected:
  static constexpr unsigned kSeed = 20'261'121;

  StreamCoderTest() : CudaTest(kSeed) {}

  void SetUp() override {
    CudaTest::SetUp();
    if (IsSkipped() || HasFatalFailure()) return;
    ASSERT_OK_AND_ASSIGN(context_, CudaContext::Create(0, {.poison_memory = true}));
    ASSERT_OK_AND_ASSIGN(lane_, context_->lanes().Borrow());
  }

  DeviceBuffer<uint8_t> Upload(std::span<const Chunk> chunks) {
    std::vector<uint8_t> bytes;
    for (const Chunk& chunk : chunks) {
      bytes.insert(bytes.end(), chunk.bytes.begin(), chunk.bytes.end());
    }
    auto buffer = DeviceBuffer<uint8_t>::Upload(
        context_->memory(), "vertices", std::span<const uint8_t>(bytes), lane_->stream().get());
    EXPECT_OK(buffer);
    return *std::move(buffer);
  }

  // With parts of so few bytes, a writer encodes in as many as it may, once it has encoded before.
  static constexpr size_t kSmallParts = 16;

  absl::StatusOr<DeviceStreamWriter> WriterWith(
      absl::StatusOr<std::unique_ptr<StreamCoder>> coder,
      size_t part_bytes = DeviceStreamWriter::kPartBytes) {
    if (!coder.ok()) return coder.status();
    return DeviceStreamWriter::Create(*std::move(coder), context_, lane_, part_bytes);
  }

  static std::vector<DeviceStreamWriter::Chunk> PlacesOf(std::span<const Chunk> chunks,
                                                         std::span<const uint32_t> numbers) {
    std::vector<uint64_t> first(chunks.size());
    for (size_t i = 1; i < chunks.size(); ++i) first[i] = first[i - 1] + chunks[i - 1].points;
    std::vector<DeviceStreamWriter::Chunk> places;
    for (const uint32_t i : numbers) {
      places.push_back({first[i], static_cast<uint32_t>(chunks[i].points)});
    }
    return places;
  }

  // Full chunks of each kind of data, then a smaller last one.
  static std::vector<Chunk> AllKinds(size_t points, int position_bits, int normal_bits) {
    std::vector<Chunk> chunks;
    constexpr unsigned kKinds = std::size(kAllData);
    for (unsigned i = 0; i < 2 * kKinds; ++i) {
      chunks.push_back(
          MakeChunk(points, position_bits, normal_bits, kAllData[i % kKinds], kSeed + i));
    }
    chunks.push_back(MakeChunk((points + 2) / 3, position_bits, normal_bits, Data::kWalk, kSeed));
    return chunks;
  }
  // Chunks of each of these sizes and of each kind of data. Odd sizes put the next chunks at odd places.
  static std::vector<Chunk> ChunksOf(std::span<const size_t> sizes, int position_bits,
                                     int normal_bits) {
    std::vector<Chunk> chunks;
    for (const size_t points : sizes) {
      for (const Data data : kAllData) {
        const auto seed = kSeed + static_cast<unsigned>(chunks.size());
        chunks.push_back(MakeChunk(points, position_bits, normal_bits, data, seed));
      }
    }
    return chunks;
  }
  static std::vector<uint32_t> All(std::span<const Chunk> chunks) {
    std::vector<uint32_t> numbers(chunks.size());
    for (uint32_t i = 0; i < numbers.size(); ++i) numbers[i] = i;
    return numbers;
  }

  std::shared_ptr<CudaContext> context_;
  std::shared_ptr<CudaLane> lane_;
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_CUDA_STREAMS_STREAM_CODER_TEST_H_
