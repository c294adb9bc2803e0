// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/gpu/gpu_floors.h"

#include <algorithm>

#include "tests/bench/gpu/gpu_kernels.h"

namespace latticed::bench {
namespace {

constexpr int kFloorRuns = 20;
constexpr size_t kDeviceBytes = size_t{1} << 30;
constexpr size_t kHostBytes = size_t{256} << 20;
constexpr int kBlocksPerProcessor = 8;  // times 256 threads: the most that a multiprocessor holds
constexpr double kSecondsPerMs = 1e-3;

// Device memory for the duration of a measurement.
class Scratch {
 public:
  explicit Scratch(size_t bytes) { CheckCuda(cudaMalloc(&data_, bytes), "memory of a floor"); }
  ~Scratch() { static_cast<void>(cudaFree(data_)); }
  Scratch(const Scratch&) = delete;  // one owner
  Scratch& operator=(const Scratch&) = delete;
  void* get() const { return data_; }

 private:
  void* data_ = nullptr;
};

double PerSecond(double amount, GpuTimes times) { return amount / (times.median * kSecondsPerMs); }

void MeasureDevice(GpuTimer& timer, cudaStream_t stream, GpuFloors& floors) {
  const Scratch a(kDeviceBytes), b(kDeviceBytes);
  constexpr double kBytes{kDeviceBytes};
  // The faster of the runtime's fill and ours is the limit.
  const GpuTimes set = timer.Median(stream, kFloorRuns, [&] {
    CheckCuda(cudaMemsetAsync(a.get(), 1, kDeviceBytes, stream), "a fill");
  });
  const GpuTimes fill = timer.Median(stream, kFloorRuns, [&] {
    CheckCuda(
        LaunchFill(static_cast<float4*>(a.get()), kDeviceBytes / sizeof(float4), 1.5f, stream),
        "a fill");
  });
  floors.written = std::max(PerSecond(kBytes, set), PerSecond(kBytes, fill));
  floors.copied = PerSecond(2 * kBytes, timer.Median(stream, kFloorRuns, [&] {
    CheckCuda(cudaMemcpyAsync(b.get(), a.get(), kDeviceBytes, cudaMemcpyDeviceToDevice, stream),
              "a copy");
  }));
}

void MeasureHost(GpuTimer& timer, cudaStream_t stream, GpuFloors& floors) {
  const Scratch device(kHostBytes);
  void* host = nullptr;
  CheckCuda(cudaHostAlloc(&host, kHostBytes, cudaHostAllocDefault), "pinned memory");
  constexpr double kBytes{kHostBytes};
  floors.to_device = PerSecond(kBytes, timer.Median(stream, kFloorRuns, [&] {
    CheckCuda(cudaMemcpyAsync(device.get(), host, kHostBytes, cudaMemcpyHostToDevice, stream),
              "a copy to the device");
  }));
  floors.to_host = PerSecond(kBytes, timer.Median(stream, kFloorRuns, [&] {
    CheckCuda(cudaMemcpyAsync(host, device.get(), kHostBytes, cudaMemcpyDeviceToHost, stream),
              "a copy to the host");
  }));
  CheckCuda(cudaFreeHost(host), "pinned memory");
}

void MeasureArithmetic(GpuTimer& timer, cudaStream_t stream, GpuFloors& floors) {
  int device = 0, processors = 0;
  CheckCuda(cudaGetDevice(&device), "the device");
  CheckCuda(cudaDeviceGetAttribute(&processors, cudaDevAttrMultiProcessorCount, device),
            "the device");
  constexpr int kWaves = 8;
  const int blocks = kWaves * kBlocksPerProcessor * processors;
  const auto threads = static_cast<size_t>(blocks) * kMultiplyAddThreads;
  const Scratch out(threads * sizeof(float));
  floors.multiply_adds = PerSecond(
      static_cast<double>(threads) * kMultiplyAddsPerThread, timer.Median(stream, kFloorRuns, [&] {
        CheckCuda(LaunchMultiplyAdds(blocks, 0.75f, static_cast<float*>(out.get()), stream),
                  "multiply-adds");
      }));
}

}  // namespace

GpuFloors MeasureGpuFloors(GpuTimer& timer, cudaStream_t stream) {
  GpuFloors floors;
  MeasureDevice(timer, stream, floors);
  MeasureHost(timer, stream, floors);
  MeasureArithmetic(timer, stream, floors);
  return floors;
}

}  // namespace latticed::bench
