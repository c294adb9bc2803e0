// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Times work on a stream by events. Each run starts after a flush of the L2 cache and behind a gate
// (gpu.h).
//
//   stream   … memset 256 MiB | gate | event 0 | work | event 1 …
//   host     enqueues all of this, then opens the gate: gaps between launches are the device's own
//
// Errors   end the program
// Threads  one; uses the device that was current at construction
#ifndef LATTICED_TESTS_BENCH_GPU_GPU_TIMER_H_
#define LATTICED_TESTS_BENCH_GPU_GPU_TIMER_H_

#include <cuda_runtime_api.h>

#include <functional>
#include <vector>

#include "tests/bench/gpu/gpu.h"

namespace latticed::bench {

// Ends the program if the call failed.
void CheckCuda(cudaError_t error, const char* what);

class GpuTimer {
 public:
  GpuTimer();
  ~GpuTimer();
  GpuTimer(const GpuTimer&) = delete;  // owns device memory
  GpuTimer& operator=(const GpuTimer&) = delete;

  // Waits for the work that `enqueue` puts on the stream. Returns its milliseconds.
  double Time(cudaStream_t stream, const std::function<void()>& enqueue);
  // The same, with further events that `enqueue` adds by Mark. Returns the milliseconds from each
  // event to the next, up to the end.
  std::vector<double> TimeMarks(cudaStream_t stream, const std::function<void()>& enqueue);
  void Mark(cudaStream_t stream);

  // Median and minimum of `runs` runs, after two that do not count.
  GpuTimes Median(cudaStream_t stream, int runs, const std::function<void()>& enqueue);

  void FlushL2(cudaStream_t stream);

 private:
  void Close(cudaStream_t stream);
  void Open();

  void* flushed_ = nullptr;
  unsigned* gate_ = nullptr;  // pinned; the largest ticket that may pass
  unsigned ticket_ = 0;
  std::vector<cudaEvent_t> events_;
  size_t marks_ = 0;
};

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_GPU_GPU_TIMER_H_
