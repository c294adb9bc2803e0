// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/lattices/scene_lattice.h"

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/ffd/sum/lattice_groups.h"
#include "fmt/format.h"

namespace latticed {
namespace {

using Moves = std::shared_ptr<const std::vector<Vec3d>>;

// What all lattices but `left_out` move the control points of the plan.
Moves SumOfMoves(const SceneLattices& lattices, size_t left_out) {
  const auto count = lattices[0].map->planned_count();
  auto sum = std::make_shared<std::vector<Vec3d>>(count);
  for (size_t k = 0; k < lattices.size(); ++k) {
    if (k == left_out) continue;
    for (size_t i = 0; i < count; ++i) (*sum)[i] += (*lattices[k].moves)[i];
  }
  return sum;
}

void Append(const std::vector<Vec3d>& points, std::vector<Vec3d>& all) {
  all.insert(all.end(), points.begin(), points.end());
}

}  // namespace

size_t PlaceOf(const SceneLattices& lattices, uint32_t number) {
  const auto found = std::ranges::find(lattices, number, &SceneLattice::number);
  return static_cast<size_t>(found - lattices.begin());
}

absl::Status CheckLattice(const SceneLattices& lattices, uint32_t number, std::string_view field) {
  LATTICED_RETURN_IF_ERROR(error::CheckRange(field, number, 0, lattices.back().number));
  if (PlaceOf(lattices, number) < lattices.size()) return absl::OkStatus();
  return error::InvalidField(field, fmt::format("lattice {} was removed", number), "OUT_OF_RANGE");
}

absl::StatusOr<PlannedLattices> PlanLattices(const std::map<uint32_t, LatticeStructure>& structures,
                                             std::span<const Vec3d> mesh) {
  PlannedLattices result;
  std::vector<LatticeStructure> parts;
  for (const auto& [number, structure] : structures) {
    result.lattices.push_back({.number = number});
    parts.push_back(structure);
  }
  if (parts.size() == 1) {
    result.lattices[0].map = std::make_shared<const OutsideMap>(parts[0]);
    result.structures.push_back(result.lattices[0].map->continued());
    return result;
  }
  LATTICED_ASSIGN_OR_RETURN(const auto groups, GroupLattices(parts, mesh));
  auto rest = std::make_shared<std::vector<Vec3d>>();
  for (const LatticeGroup& group : groups)
    Append(IdentityControlPoints(group.sum.structure), *rest);
  size_t first = 0;
  for (const LatticeGroup& group : groups) {
    const LatticeStructure& sum = group.sum.structure;
    for (size_t i = 0; i < group.members.size(); ++i) {
      const size_t k = group.members[i];
      OutsideMap map(parts[k], 1, sum, group.sum.parts[i]);
      if (groups.size() > 1) map.PlaceAmong(first, rest);
      result.lattices[k].map = std::make_shared<const OutsideMap>(std::move(map));
    }
    first += static_cast<size_t>(sum.control_point_count());
    result.structures.push_back(sum);
  }
  return result;
}

void TakePoints(SceneLattices& lattices, size_t k, double strength,
                const std::vector<Vec3d>& points) {
  SceneLattice& lattice = lattices[k];
  lattice.map = WithStrength(lattice.map, strength);
  lattice.points = std::make_shared<const std::vector<Vec3d>>(points);
  if (lattices.size() == 1) return;
  lattice.moves = std::make_shared<const std::vector<Vec3d>>(lattice.map->Moves(points));
}

std::shared_ptr<const std::vector<Vec3d>> PlannedPoints(const SceneLattices& lattices) {
  const SceneLattice& first = lattices[0];
  if (first.map->is_identity()) return first.points;
  if (lattices.size() == 1) {
    return std::make_shared<const std::vector<Vec3d>>(first.map->Continue(*first.points));
  }
  return std::make_shared<const std::vector<Vec3d>>(
      first.map->Moved(*SumOfMoves(lattices, lattices.size())));
}

std::shared_ptr<const OutsideMap> MapAmongOthers(const SceneLattices& lattices, size_t k) {
  if (lattices.size() == 1) return lattices[k].map;
  auto map = std::make_shared<OutsideMap>(*lattices[k].map);
  map->AddOthers(SumOfMoves(lattices, k));
  return map;
}

}  // namespace latticed
