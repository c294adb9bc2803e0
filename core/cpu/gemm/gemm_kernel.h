// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Pipelines kGemm, kGemm12 and kControlNet: samples, products, normals, shared points, chunk by
// chunk.
//
//   facet   Pu x Pv
//   smooth  with N the interpolated vertex normal, e1, e2 the rest edges and f the facet normal,
//           cof(J) N ~ (N.f) Pu x Pv + (N.e1) Pv x Pf + (N.e2) Pf x Pu
//   Where the float products cancel beyond kMostCondition, the definition in double takes their place: at folds, in
//   collapsed lattices and in extreme slivers. It does so too in triangles whose weight has no gradient.
//
// A tile is always one chunk, for any request and any number of threads: a BLAS may round
// differently for another shape, and the same control points must give the same bits.
//
// Beside the chunks that are named, those are evaluated that own shared points of theirs and are older than the control
// points. So a call brings the named chunks to the given control points, whatever earlier calls named.
//
// Errors   kInternal from a product; nothing else once it is made
// Threads  one thread at a time; uses those of the arena inside
#ifndef LATTICED_CORE_CPU_GEMM_GEMM_KERNEL_H_
#define LATTICED_CORE_CPU_GEMM_GEMM_KERNEL_H_

#include <tbb/enumerable_thread_specific.h>

#include <array>
#include <memory>
#include <vector>

#include "core/cpu/cpu_context.h"
#include "core/cpu/gemm/gemm_stages.h"
#include "core/cpu/gemm/patch_sampler.h"
#include "core/cpu/vertex_kernel.h"
#include "core/ffd/direct_ffd.h"
#include "core/ffd/plan/shared_points.h"
#include "core/view/vertex_layout.h"

namespace latticed {

class GemmKernel : public VertexKernel {
 public:
  GemmKernel(std::shared_ptr<const DeformPlan> plan, std::shared_ptr<const SharedPoints> shared,
             const StageMatrices& stage, Pipeline pipeline, const ViewSpec& spec,
             std::shared_ptr<CpuContext> context);

  absl::Status Evaluate(std::span<const Vec3d> control_points, const QuantisationBox& box,
                        std::span<const uint32_t> chunks, std::span<uint8_t> vertices) override;
  MemoryUse memory() const override;
  // The most that memory() returns for a kernel on `threads` threads.
  [[nodiscard]] static uint64_t MostBytes(const DeformPlan& plan, const StageMatrices& stage,
                                          size_t threads);

 private:
  static constexpr double kMostCondition = 1e3;

  struct Tile {
    std::vector<double> samples, by_normal;  // m x 3t
    std::vector<float> surface;              // [P; Pu; Pv], rows x 3t
    std::vector<float> across;               // Pf, q x 3t
    std::vector<Vec3d> centres;
    GemmStages::Scratch scratch;
  };
  struct Frame;  // what one evaluation shares between its tiles

  // Returns the chunks to evaluate, ascending, and marks them as old until they have been evaluated.
  std::vector<uint32_t> Begin(std::span<const Vec3d> control_points,
                              std::span<const uint32_t> named);
  absl::Status EvaluateChunk(const Frame& frame, size_t chunk, Tile& tile) const;
  // Copies the shared points of all patches of `chunks` from their owners. `attached`: by seam.
  void CopySharedPoints(const Frame& frame, const std::vector<bool>& attached,
                        std::span<const uint32_t> chunks) const;
  void CopyPoints(const Frame& frame, const SharedCopy& copy) const;
  void EvaluateOrphan(const Frame& frame, const SharedPoints::Orphan& orphan) const;
  void WritePatch(const Frame& frame, const Tile& tile, size_t patch, size_t column,
                  size_t columns) const;
  Vec3d NormalAt(const Frame& frame, const Tile& tile, size_t patch, size_t column, size_t columns,
                 size_t point) const;
  Vec3d DefinitionNormal(const Frame& frame, size_t patch, size_t point) const;
  std::array<double, 3> Barycentrics(size_t point) const;

  std::shared_ptr<const DeformPlan> owned_plan_;
  const DeformPlan& plan_;
  std::shared_ptr<const SharedPoints> shared_;
  std::vector<Vec3d> newest_;  // control points of the last call
  std::vector<bool> is_old_;   // by chunk: whether its vertices may be of others
  const StageMatrices& stage_;
  ViewSpec spec_;
  VertexLayout layout_;
  GemmStages stages_;
  std::shared_ptr<CpuContext> context_;
  tbb::enumerable_thread_specific<Tile> tiles_;
};

}  // namespace latticed

#endif  // LATTICED_CORE_CPU_GEMM_GEMM_KERNEL_H_
