// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What an evaluation with a tolerance asks of a pipeline on the device: the kernels that bound patches, and the one that
// writes points. Twin of core/cpu/adaptive/surface/adaptive_surface.h.
//
// Errors   those of kernel_call.h
// Threads  one at a time, on the view's lane
#ifndef LATTICED_CUDA_ADAPTIVE_SURFACE_CUDA_ADAPTIVE_SURFACE_H_
#define LATTICED_CUDA_ADAPTIVE_SURFACE_CUDA_ADAPTIVE_SURFACE_H_

#include <string_view>
#include <vector>

#include "core/backend.h"
#include "cuda/adaptive/adaptive_kernels.h"

namespace latticed {

// A kernel and its name for measurements.
struct AdaptiveStage {
  kernels::KernelCall call;
  std::string_view name;
};

class CudaAdaptiveSurface {
 public:
  virtual ~CudaAdaptiveSurface() = default;

  // The units of bounds and of the launch's tolerance in world units.
  virtual double UnitsPerWorld(const QuantisationBox& box) const = 0;
  // Sets what the launch lacks: its tables and polynomials. `launch` has what all pipelines have.
  virtual void Begin(const QuantisationBox& box, kernels::AdaptiveLaunch& launch) = 0;
  // How far patches reach, once a view; no kernel where bounds do not ask.
  virtual kernels::KernelCall ReachCall(const kernels::AdaptiveLaunch& launch) const = 0;
  // Appends the stages from the control points to the bounds of the named patches.
  virtual void AddBoundStages(const kernels::AdaptiveLaunch& launch,
                              std::vector<AdaptiveStage>& stages) const = 0;
  virtual kernels::KernelCall PointsCall(const kernels::AdaptiveLaunch& launch) const = 0;
  virtual MemoryUse memory() const = 0;
};

}  // namespace latticed

#endif  // LATTICED_CUDA_ADAPTIVE_SURFACE_CUDA_ADAPTIVE_SURFACE_H_
