// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/gpu/gpu_timer.h"

#include <atomic>

#include "cuda/device/cuda_status.h"
#include "tests/bench/gpu/gpu_kernels.h"
#include "tests/bench/scenario.h"

namespace latticed::bench {
namespace {

constexpr size_t kFlushBytes = size_t{256} << 20;  // several times the L2 cache: 50 MB on an H200
constexpr int kTimerWarmUps = 2;

}  // namespace

void CheckCuda(cudaError_t error, const char* what) { CheckOk(CudaStatus(error, what)); }

GpuTimer::GpuTimer() {
  CheckCuda(cudaMalloc(&flushed_, kFlushBytes), "the buffer that flushes the cache");
  void* gate = nullptr;
  CheckCuda(cudaHostAlloc(&gate, sizeof(*gate_), cudaHostAllocMapped), "the gate");
  gate_ = static_cast<unsigned*>(gate);
  *gate_ = 0;
}

GpuTimer::~GpuTimer() {
  for (const cudaEvent_t event : events_) static_cast<void>(cudaEventDestroy(event));
  static_cast<void>(cudaFreeHost(gate_));
  static_cast<void>(cudaFree(flushed_));
}

void GpuTimer::FlushL2(cudaStream_t stream) {
  CheckCuda(cudaMemsetAsync(flushed_, static_cast<int>(ticket_ % 256), kFlushBytes, stream),
            "the cache's flush");
}

void GpuTimer::Close(cudaStream_t stream) {
  void* device_gate = nullptr;
  CheckCuda(cudaHostGetDevicePointer(&device_gate, gate_, 0), "the gate");
  CheckCuda(LaunchGate(static_cast<const unsigned*>(device_gate), ++ticket_, stream), "the gate");
}

void GpuTimer::Open() { std::atomic_ref(*gate_).store(ticket_, std::memory_order_release); }

void GpuTimer::Mark(cudaStream_t stream) {
  if (marks_ == events_.size()) {
    cudaEvent_t event = nullptr;
    CheckCuda(cudaEventCreate(&event), "an event");
    events_.push_back(event);
  }
  CheckCuda(cudaEventRecord(events_[marks_++], stream), "an event");
}

std::vector<double> GpuTimer::TimeMarks(cudaStream_t stream, const std::function<void()>& enqueue) {
  marks_ = 0;
  FlushL2(stream);
  Close(stream);
  Mark(stream);
  enqueue();
  Mark(stream);
  Open();
  CheckCuda(cudaEventSynchronize(events_[marks_ - 1]), "the timed work");
  std::vector<double> times;
  for (size_t i = 1; i < marks_; ++i) {
    float ms = 0;
    CheckCuda(cudaEventElapsedTime(&ms, events_[i - 1], events_[i]), "an event");
    times.push_back(double{ms});
  }
  return times;
}

double GpuTimer::Time(cudaStream_t stream, const std::function<void()>& enqueue) {
  return TimeMarks(stream, enqueue).front();
}

GpuTimes GpuTimer::Median(cudaStream_t stream, int runs, const std::function<void()>& enqueue) {
  std::vector<double> times;
  for (int run = -kTimerWarmUps; run < runs; ++run) {
    const double ms = Time(stream, enqueue);
    if (run >= 0) times.push_back(ms);
  }
  return MedianAndLeast(std::move(times));
}

}  // namespace latticed::bench
