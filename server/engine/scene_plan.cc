// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The plan of a Scene, and what follows from it.
#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "core/base/catch_bad_alloc.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "server/engine/scene.h"

namespace latticed {
namespace {

// Times in a header take a few bytes more or less. What a scene reserves does not depend on them.
uint64_t WholePages(uint64_t bytes) {
  constexpr uint64_t kPage = 4096;
  return (bytes + kPage - 1) / kPage * kPage;
}

bool KeepsVolume(const EditBatch& batch, const SceneState& state) {
  return batch.keep_volume.has_value() ||
         std::ranges::any_of(state.lattices, [](const SceneLattice& lattice) {
           return lattice.constraints->volume.has_value();
         });
}

}  // namespace

absl::StatusOr<Scene::Prepared> Scene::Prepare(const PlanKey& key, StopCheck stop) const {
  return CatchBadAlloc("the scene's plan", [&]() -> absl::StatusOr<Prepared> {
    RenderBackend& backend = *context_.backend;
    LATTICED_RETURN_IF_ERROR(backend.health().status());
    const uint64_t least = LeastPlanBytes(*config_.mesh);
    LATTICED_ASSIGN_OR_RETURN(auto memory,
                              backend.memory().Reserve("the scene's plan", least, config_.account));
    ProbeMemory(least);
    for (const auto& [number, structure] : key.structures) {
      LATTICED_RETURN_IF_ERROR(Validate(structure));
    }
    SceneState state;
    LATTICED_ASSIGN_OR_RETURN(auto planned, PlanLattices(key.structures, config_.mesh->positions));
    state.lattices = std::move(planned.lattices);
    LATTICED_ASSIGN_OR_RETURN(
        auto plan, MakePlan(config_.mesh, planned.structures[0], config_.crease_angle, stop,
                            key.weights, std::span(planned.structures).subspan(1)));
    LATTICED_ASSIGN_OR_RETURN(auto target, backend.Prepare(plan, PipelineFor(*plan)));
    LATTICED_RETURN_IF_ERROR(stop());
    state.patch_tree = std::make_shared<const PatchTree>(*plan);
    state.patches_on_faces = PatchesThatMayTear(*plan, state.lattices);
    state.measures =
        std::make_shared<SceneMeasures>(plan, &backend.memory(), config_.account, context_.arena);
    state.influential = std::make_shared<const std::vector<bool>>(InfluentialPoints(*plan));
    const uint64_t bytes = HostBytes(target->memory()) + state.patch_tree->MemoryBytes() +
                           LatticeBytes(state.lattices) + LeastHistoryBytes(state.lattices) +
                           WholePages(config_.stored_header.size());
    LATTICED_RETURN_IF_ERROR(memory.Resize("the scene's plan", bytes));
    auto slot = std::make_shared<TargetSlot>(&backend, std::move(target), plan, std::move(memory));
    state.plan = std::move(plan);
    return Prepared{std::move(state), std::move(slot)};
  });
}

Pipeline Scene::PipelineFor(const DeformPlan& plan) const {
  const bool is_turned = !plan.turned.empty() && config_.pipeline == Pipeline::kFused;
  return is_turned ? Pipeline::kGemm : config_.pipeline;
}

absl::StatusOr<Scene::Prepared> Scene::PrepareFor(const EditBatch& batch, const PlanKey& key,
                                                  StopCheck stop) const {
  LATTICED_ASSIGN_OR_RETURN(auto prepared, Prepare(key, stop));
  // Here, and not under the scene's lock, where the next edit that keeps the volume would make them.
  if (KeepsVolume(batch, *State())) {
    LATTICED_RETURN_IF_ERROR(
        prepared.state.measures->Moments(SurfaceMoments::Order::kVolume, stop).status());
  }
  return prepared;
}

}  // namespace latticed
