// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <memory>
#include <numeric>
#include <optional>
#include <utility>

#include "core/base/status_macros.h"
#include "core/view/spanned/spanned_view.h"
#include "cuda/adaptive/cuda_adaptive_view.h"
#include "cuda/cuda_backend.h"
#include "cuda/view/cuda_view.h"
#include "tests/bench/gpu/gpu.h"
#include "tests/bench/gpu/gpu_floors.h"
#include "tests/bench/gpu/gpu_timer.h"
#include "tests/bench/paper/comparators.h"
#include "tests/bench/scenario.h"

namespace latticed::bench {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kWarmUps = 3;
constexpr double kWarmUpMs = 30;
// The matrices of (24) and a cuBLAS workspace, or a comparator's control points and vertices.
constexpr uint64_t kOwnBytes = uint64_t{2} << 30;

double Milliseconds(Clock::time_point from, Clock::time_point to) {
  return std::chrono::duration<double, std::milli>(to - from).count();
}

// Polls, because a blocking wait would add the thread's wake-up time.
void Await(const CudaLane& lane) {
  cudaError_t state = cudaErrorNotReady;
  while (state == cudaErrorNotReady) state = cudaStreamQuery(lane.stream().get());
  CheckCuda(state, "the timed work");
  static_cast<void>(cudaGetLastError());  // "not ready", which the next launch would report
}

CudaLane& LaneOf(DeformView& view) {
  if (auto* const adaptive = dynamic_cast<CudaAdaptiveView*>(&view)) return adaptive->lane();
  auto* const cuda_view = dynamic_cast<CudaView*>(&view);
  if (cuda_view == nullptr) CheckOk(absl::InternalError("not a view of the CUDA backend"));
  return cuda_view->lane();
}

// The lanes of all parts if the view spans devices, otherwise of the view.
std::vector<CudaLane*> LanesOf(DeformView& view) {
  const auto* const spanned = dynamic_cast<SpannedView*>(&view);
  if (spanned == nullptr) return {&LaneOf(view)};
  std::vector<CudaLane*> lanes;
  for (const SpannedView::Part& part : spanned->parts()) lanes.push_back(&LaneOf(*part.view));
  return lanes;
}

// While it lives, `mark` is called at the lane's stages.
class StageMarks {
 public:
  StageMarks(CudaLane& lane, CudaLane::StageMark mark) : lane_(lane) {
    lane_.set_stage_mark(std::move(mark));
  }
  ~StageMarks() { lane_.set_stage_mark({}); }
  StageMarks(const StageMarks&) = delete;  // removes the mark once
  StageMarks& operator=(const StageMarks&) = delete;

 private:
  CudaLane& lane_;
};

// The times of one stage in all runs.
struct StageRuns {
  std::string name;
  std::vector<double> device_ms, host_ms;
};

StageRuns& Find(std::vector<StageRuns>& stages, const std::string& name) {
  for (StageRuns& stage : stages) {
    if (stage.name == name) return stage;
  }
  return stages.emplace_back(StageRuns{.name = name, .device_ms = {}, .host_ms = {}});
}

// Loads kernels, creates buffers and handles, and lets the device's clocks rise.
void WarmUp(const CudaLane& lane, const GpuWork& work) {
  const auto start = Clock::now();
  for (int run = 0; run < kWarmUps || Milliseconds(start, Clock::now()) < kWarmUpMs; ++run) {
    CheckOk(work(run));
  }
  CheckOk(lane.stream().Synchronize("the warm-up"));
}

// Alternates between the two sets of control points.
template <class Maker>
GpuWork WorkOf(Maker& maker, std::span<const std::vector<Vec3d>, 2> control_points) {
  return [&maker, control_points](int run) {
    maker.Enqueue(control_points[static_cast<size_t>(run) % 2]);
    return absl::OkStatus();
  };
}

class CudaGpu : public Gpu {
 public:
  CudaGpu(std::unique_ptr<Backend> backend, std::shared_ptr<CudaContext> context)
      : backend_(std::move(backend)), context_(std::move(context)) {}

  Backend& backend() override { return *backend_; }

  const GpuFloors& floors() override {
    if (!floors_) floors_ = MeasureGpuFloors(timer_, context_->stream().get());
    return *floors_;
  }

  absl::StatusOr<TensorTimes> TensorProduct(const std::shared_ptr<const DeformPlan>& plan,
                                            const TensorSurfaces& surfaces,
                                            std::span<const std::vector<Vec3d>, 2> control_points,
                                            const TensorCheck& check, int runs) override {
    TensorProductMaker maker(plan, surfaces, *context_);
    const GpuWork work = WorkOf(maker, control_points);
    CheckOk(work(0));
    LATTICED_RETURN_IF_ERROR(check(maker.Download()));
    return TensorTimes{.stages = Stages(maker.lane(), work, runs),
                       .whole = Times(maker.lane(), work, runs)};
  }

  BezierNets ControlNets(const std::shared_ptr<const DeformPlan>& plan,
                         std::span<const std::vector<Vec3d>, 2> control_points, int runs) override {
    BezierNetMaker maker(plan, *context_);
    const GpuWork work = WorkOf(maker, control_points);
    CheckOk(work(0));
    auto nets = maker.Download();
    return {std::move(nets), Times(maker.lane(), work, runs)};
  }

  GpuTimes DeviceTime(DeformView& view, const GpuWork& work, int runs) override {
    return Times(LaneOf(view), work, runs);
  }

  GpuTimes LaunchToResult(DeformView& view, const GpuWork& work, int runs) override {
    const CudaLane& lane = LaneOf(view);
    WarmUp(lane, work);
    std::vector<double> times;
    times.reserve(static_cast<size_t>(runs));
    for (int run = 0; run < runs; ++run) {
      timer_.FlushL2(lane.stream().get());
      CheckOk(lane.stream().Synchronize("the cache's flush"));
      const auto start = Clock::now();
      CheckOk(work(run));
      Await(lane);
      times.push_back(Milliseconds(start, Clock::now()));
    }
    return MedianAndLeast(std::move(times));
  }

  int device_count() const override {
    int count = 0;
    CheckCuda(cudaGetDeviceCount(&count), "the devices");
    return count;
  }

  std::unique_ptr<Backend> OnDevices(int count) override {
    CudaOptions options{.span_patches = 1, .encoder = nullptr, .refuse_allocation = {}};
    options.devices.resize(static_cast<size_t>(count));
    std::iota(options.devices.begin(), options.devices.end(), 0);
    return Checked(MakeCudaBackend(options));
  }

  WallTimes WallTime(DeformView& view, const GpuWork& work, int runs) override {
    const std::vector<CudaLane*> lanes = LanesOf(view);
    for (const CudaLane* lane : lanes) WarmUp(*lane, work);
    for (const CudaLane* lane : lanes) Await(*lane);
    std::vector<double> whole, enqueue;
    for (int run = 0; run < runs; ++run) {
      const auto start = Clock::now();
      CheckOk(work(run));
      const auto enqueued = Clock::now();
      for (const CudaLane* lane : lanes) Await(*lane);
      whole.push_back(Milliseconds(start, Clock::now()));
      enqueue.push_back(Milliseconds(start, enqueued));
    }
    return {.whole = MedianAndLeast(std::move(whole)),
            .enqueue_ms = MedianAndLeast(std::move(enqueue)).median};
  }

  std::vector<GpuStage> Stages(DeformView& view, const GpuWork& work, int runs) override {
    return Stages(LaneOf(view), work, runs);
  }

  GpuTimes Formula24(int n, int segments, int runs) override {
    const auto lane = Checked(context_->lanes().Borrow());
    auto room = Checked(DeviceReservation::Create(
        context_->memory(), "formula (24)",
        context_->StageBytesToCome(n, segments) + lane->GemmBytesToCome()));
    const auto stage = Checked(context_->Stage(n, segments, room));
    auto* const gemm = Checked(lane->gemm(room));
    const cudaStream_t stream = lane->stream().get();
    const size_t rows = 3 * stage->q(), m = stage->m();
    const auto product = Checked(
        DeviceBuffer<double>::Create(context_->memory(), "stage_matrices", rows * m, stream));
    const GpuTimes times = timer_.Median(stream, runs, [&] {
      CheckOk(
          gemm->Multiply(stage->bernstein(), stage->inverse(), {product.data(), rows, m, rows}));
    });
    CheckOk(lane->stream().Synchronize("formula (24)"));
    return times;
  }

 private:
  std::vector<GpuStage> Stages(CudaLane& lane, const GpuWork& work, int runs) {
    WarmUp(lane, work);
    std::vector<StageRuns> stages;
    for (int run = 0; run < runs; ++run) AddStages(lane, work, run, stages);
    std::vector<GpuStage> result;
    result.reserve(stages.size());
    for (StageRuns& stage : stages) {
      result.push_back({.name = stage.name,
                        .device_ms = MedianAndLeast(std::move(stage.device_ms)).median,
                        .host_ms = MedianAndLeast(std::move(stage.host_ms)).median});
    }
    return result;
  }

  GpuTimes Times(const CudaLane& lane, const GpuWork& work, int runs) {
    WarmUp(lane, work);
    std::vector<double> times;
    times.reserve(static_cast<size_t>(runs));
    for (int run = 0; run < runs; ++run) {
      times.push_back(timer_.Time(lane.stream().get(), [&] { CheckOk(work(run)); }));
    }
    return MedianAndLeast(std::move(times));
  }

  void AddStages(CudaLane& lane, const GpuWork& work, int run, std::vector<StageRuns>& stages) {
    const cudaStream_t stream = lane.stream().get();
    std::vector<std::string> names;
    std::vector<Clock::time_point> enqueued;
    const StageMarks marks(lane, [&](std::string_view name) {
      enqueued.push_back(Clock::now());
      names.emplace_back(name);
      timer_.Mark(stream);
    });
    const std::vector<double> times = timer_.TimeMarks(stream, [&] {
      enqueued.push_back(Clock::now());
      CheckOk(work(run));
      enqueued.push_back(Clock::now());
    });
    names.emplace_back("rest");
    std::vector<StageRuns> sums;
    for (size_t i = 0; i < names.size(); ++i) {
      StageRuns& sum = Find(sums, names[i]);
      sum.device_ms.resize(1);
      sum.host_ms.resize(1);
      sum.device_ms[0] += times[i];
      sum.host_ms[0] += Milliseconds(enqueued[i], enqueued[i + 1]);
    }
    for (const StageRuns& sum : sums) {
      StageRuns& stage = Find(stages, sum.name);
      stage.device_ms.push_back(sum.device_ms[0]);
      stage.host_ms.push_back(sum.host_ms[0]);
    }
  }

  std::unique_ptr<Backend> backend_;
  std::shared_ptr<CudaContext> context_;  // the benchmark's own, beside the backend's
  GpuTimer timer_;
  std::optional<GpuFloors> floors_;
};

absl::StatusOr<Gpu*> MakeGpu() {
  const CudaOptions options{.encoder = nullptr, .refuse_allocation = {}};
  LATTICED_ASSIGN_OR_RETURN(auto backend, MakeCudaBackend(options));
  CudaOptions own = options;
  own.memory_bytes = kOwnBytes;
  LATTICED_ASSIGN_OR_RETURN(auto context, CudaContext::Create(own.devices.front(), own));
  CheckCuda(cudaSetDevice(own.devices.front()), "the device");
  return new CudaGpu(std::move(backend), std::move(context));  // lives until the process ends
}

}  // namespace

absl::StatusOr<Gpu*> TheGpu() {
  static const absl::StatusOr<Gpu*>* const gpu = new absl::StatusOr<Gpu*>(MakeGpu());
  return *gpu;
}

}  // namespace latticed::bench
