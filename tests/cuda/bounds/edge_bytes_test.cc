// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The bytes that the device makes of bounds are those of the host, and only chunks that changed reach the host.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "core/patches/edge_bound.h"
#include "cuda/bounds/bound_kernels.h"
#include "cuda/device/cuda_context.h"
#include "cuda/device/device_buffer.h"
#include "tests/cuda/cuda_test.h"

namespace latticed::testing {
namespace {

constexpr uint32_t kBitsSeed = 7;
constexpr uint8_t kUntouched = 0xee;

// Around each bound that a byte stands for, the ends of float, and 20,000 floats of any bits.
std::vector<float> BoundsOfAllKinds(double unit) {
  std::vector<float> bounds{
      0, std::numeric_limits<float>::denorm_min(), std::numeric_limits<float>::max(),
      std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()};
  for (int byte = 0; byte < 255; ++byte) {
    const auto at = static_cast<float>(EdgeBound(static_cast<uint8_t>(byte), unit));
    for (const float bound : {std::nextafter(at, 0.0f), at, std::nextafter(at, INFINITY)}) {
      bounds.push_back(bound);
    }
  }
  std::mt19937 random(kBitsSeed);
  for (int i = 0; i < 20'000; ++i) {
    bounds.push_back(std::bit_cast<float>(static_cast<uint32_t>(random()) & 0x7fffffff));
  }
  return bounds;
}

// Chunks of 0 to 96 edges.
std::vector<uint32_t> FirstOfChunks(uint32_t edges) {
  std::vector<uint32_t> first{0};
  for (uint32_t size = 0; first.back() < edges; size = (size + 31) % 97) {
    first.push_back(std::min(first.back() + size, edges));
  }
  return first;
}

class EdgeBytes : public CudaTest {
 protected:
  EdgeBytes() : CudaTest(kBitsSeed) {}
};

TEST_F(EdgeBytes, AreTheHostsAndOnlyChangedChunksAreSent) {
  constexpr double kUnit = 0x1p-31;
  std::vector<float> bounds = BoundsOfAllKinds(kUnit);
  const auto edges = static_cast<uint32_t>(bounds.size());
  const std::vector<uint32_t> first = FirstOfChunks(edges);
  const auto chunks = static_cast<uint32_t>(first.size() - 1);
  ASSERT_NE(chunks % kernels::kEdgeByteChunks, 0u);
  ASSERT_OK_AND_ASSIGN(const auto context, CudaContext::Create(0, {}));
  ASSERT_OK_AND_ASSIGN(const auto stream, CudaStream::Create());
  const auto upload = [&]<typename T>(std::span<const T> from) {
    return DeviceBuffer<T>::Upload(context->memory(), "bounds", from, stream.get());
  };
  std::vector<uint8_t> known(edges);
  ASSERT_OK_AND_ASSIGN(const auto on_device, upload(std::span<const float>(bounds)));
  ASSERT_OK_AND_ASSIGN(const auto of_chunks, upload(std::span<const uint32_t>(first)));
  ASSERT_OK_AND_ASSIGN(const auto bytes, upload(std::span<const uint8_t>(known)));
  ASSERT_OK_AND_ASSIGN(const auto host_bytes, context->pinned().Borrow(edges));
  ASSERT_OK_AND_ASSIGN(const auto host_changed, context->pinned().Borrow(chunks));
  const auto* const changed = reinterpret_cast<const uint32_t*>(host_changed.data());
  const kernels::EdgeBytesLaunch launch{
      .edge_maxima = reinterpret_cast<const uint32_t*>(on_device.data()),
      .first_edges = of_chunks.data(),
      .chunk_count = chunks,
      .unit = kUnit,
      .bytes = bytes.data(),
      .host_bytes = host_bytes.data(),
      .host_changed = reinterpret_cast<uint32_t*>(host_changed.data())};
  std::mt19937 random(kBitsSeed);
  // All edges; none; then a few in the middle.
  for (const uint32_t moved : {edges, 0u, 5u}) {
    for (uint32_t i = 0; moved < edges && i < moved; ++i) bounds[random() % edges] = 1;
    ASSERT_OK(CudaStatus(cudaMemcpyAsync(on_device.data(), bounds.data(), edges * sizeof(float),
                                         cudaMemcpyHostToDevice, stream.get()),
                         "the bounds"));
    std::fill_n(host_bytes.data(), edges, kUntouched);

    ASSERT_OK(CudaStatus(kernels::EdgeBytesCall(launch).Launch(stream.get()), "the bytes"));
    ASSERT_OK(stream.Synchronize("the bytes"));

    for (uint32_t chunk = 0; chunk < chunks; ++chunk) {
      bool differs = false;
      for (uint32_t e = first[chunk]; e < first[chunk + 1]; ++e) {
        differs |= EdgeBoundByte(bounds[e], kUnit) != known[e];
      }
      ASSERT_EQ((changed[chunk / 32] >> chunk % 32 & 1) != 0, differs) << "chunk " << chunk;
      for (uint32_t e = first[chunk]; e < first[chunk + 1]; ++e) {
        known[e] = EdgeBoundByte(bounds[e], kUnit);
        ASSERT_EQ(host_bytes.data()[e], differs ? known[e] : kUntouched) << "bound " << bounds[e];
      }
    }
  }
}

}  // namespace
}  // namespace latticed::testing
