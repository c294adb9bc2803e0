// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/history/edit_layers.h"

#include <algorithm>
#include <utility>

namespace latticed {

void EditStep::Close(bool by_time_out) {
  open = false;
  timed_out = by_time_out;
  if (!by_time_out) start.clear();
}

bool EditStep::Overlaps(const EditStep& other) const {
  // Weights are of the scene.
  if (removes || other.removes) return !weights.has_value() && !other.weights.has_value();
  if (structural.has_value() || other.structural.has_value()) return true;
  if (constraints.has_value() && other.constraints.has_value()) return true;
  if (strength.has_value() && other.strength.has_value()) return true;
  if (weights.has_value() && other.weights.has_value()) return true;
  auto a = indices.begin();
  auto b = other.indices.begin();
  while (a != indices.end() && b != other.indices.end()) {
    if (*a == *b) return true;
    if (*a < *b) {
      ++a;
    } else {
      ++b;
    }
  }
  return false;
}

size_t EditStep::MemoryBytes() const {
  // A std::map node takes 32 bytes of value, 32 of links and 16 of the allocator.
  constexpr size_t kMapNodeBytes = 80;
  size_t bytes = sizeof(EditStep) + editor_id.size() + gesture_id.size() +
                 indices.capacity() * sizeof(uint32_t) + positions.capacity() * sizeof(Vec3d) +
                 start.size() * kMapNodeBytes;
  if (structural.has_value()) {
    for (const auto& knots : structural->structure.knots) bytes += knots.size() * sizeof(double);
  }
  if (constraints.has_value()) bytes += constraints->MemoryBytes();
  if (weights.has_value() && *weights != nullptr) bytes += (*weights)->size() * sizeof(float);
  return bytes;
}

EditLayers::EditLayers(Lattice base, double strength)
    : base_{.base = base, .initial = base, .strength = strength}, lattice_(std::move(base)) {}

EditLayers::EditLayers(LayersBase base, std::deque<EditStep> steps)
    : base_(std::move(base)), steps_(std::move(steps)) {
  for (const EditStep& step : steps_) bytes_ += step.MemoryBytes();
  RebuildLattice();
}

Lattice EditLayers::initial() const {
  for (auto step = steps_.rbegin(); step != steps_.rend(); ++step) {
    if (step->structural.has_value() && step->structural->replaces()) {
      return {step->structural->structure, step->positions};
    }
  }
  return base_.initial;
}

const Constraints& EditLayers::constraints() const {
  for (auto step = steps_.rbegin(); step != steps_.rend(); ++step) {
    if (step->constraints.has_value()) return *step->constraints;
  }
  return base_.constraints;
}

double EditLayers::StrengthWithout(size_t position) const {
  for (size_t n = steps_.size(); n-- > 0;) {
    if (n != position && steps_[n].strength.has_value()) return *steps_[n].strength;
  }
  return base_.strength;
}

std::optional<VertexWeights> EditLayers::WeightsWithout(size_t position) const {
  for (size_t n = steps_.size(); n-- > 0;) {
    if (n != position && steps_[n].weights.has_value()) return steps_[n].weights;
  }
  return base_.weights;
}

bool EditLayers::AbsentWithout(size_t position) const {
  for (size_t n = steps_.size(); n-- > 0;) {
    const EditStep& step = steps_[n];
    if (n == position) continue;
    if (step.removes) return true;
    if (step.structural.has_value() && step.structural->replaces()) return false;
  }
  return base_.absent;
}

size_t EditLayers::BaseBytes() const {
  const size_t own = lattice_.control_points.size();
  const size_t present = absent() ? 0 : own;
  size_t points = own - present;
  for (const Lattice* lattice : {&base_.base, &base_.initial}) {
    points += std::max(lattice->control_points.size(), present) - present;
  }
  return points * sizeof(Vec3d);
}

void EditLayers::Push(EditStep step) {
  steps_.push_back(std::move(step));
  const EditStep& top = steps_.back();
  bytes_ += top.MemoryBytes();
  if (top.structural.has_value()) {
    lattice_ = {top.structural->structure, top.positions};
    return;
  }
  for (size_t n = 0; n < top.indices.size(); ++n) {
    lattice_.control_points[top.indices[n]] = top.positions[n];
  }
}

EditStep EditLayers::Remove(size_t position) {
  bytes_ -= steps_[position].MemoryBytes();
  const bool structural = steps_[position].structural.has_value();
  if (!structural) RestorePoints(steps_[position].indices, position, lattice_.control_points);
  EditStep step = std::move(steps_[position]);
  steps_.erase(steps_.begin() + static_cast<std::ptrdiff_t>(position));
  if (structural) RebuildLattice();
  return step;
}

std::vector<Vec3d> EditLayers::PointsWithout(size_t position) const {
  std::vector<Vec3d> points = lattice_.control_points;
  RestorePoints(steps_[position].indices, position, points);
  return points;
}

void EditLayers::Close(size_t position, bool timed_out) {
  EditStep& step = steps_[position];
  bytes_ -= step.MemoryBytes();
  step.Close(timed_out);
  bytes_ += step.MemoryBytes();
}

void EditLayers::FoldOldest() {
  EditStep& oldest = steps_.front();
  bytes_ -= oldest.MemoryBytes();
  if (oldest.constraints.has_value()) base_.constraints = *std::move(oldest.constraints);
  if (oldest.strength.has_value()) base_.strength = *oldest.strength;
  if (oldest.weights.has_value()) base_.weights = std::move(oldest.weights);
  if (oldest.removes) base_.absent = true;
  if (oldest.structural.has_value()) {
    const bool replaces = oldest.structural->replaces();
    base_.base = {std::move(oldest.structural->structure), std::move(oldest.positions)};
    if (replaces) {
      base_.initial = base_.base;
      base_.absent = false;
    }
    base_.structure_step = oldest.id;
  } else {
    for (size_t n = 0; n < oldest.indices.size(); ++n) {
      base_.base.control_points[oldest.indices[n]] = oldest.positions[n];
    }
  }
  steps_.pop_front();
}

uint64_t EditLayers::structure_step() const {
  for (auto step = steps_.rbegin(); step != steps_.rend(); ++step) {
    if (step->structural.has_value()) return step->id;
  }
  return base_.structure_step;
}

const LatticeStructure& EditLayers::StructureWithout(size_t position) const {
  for (size_t n = steps_.size(); n-- > 0;) {
    if (n != position && steps_[n].structural.has_value()) return steps_[n].structural->structure;
  }
  return base_.base.structure;
}

void EditLayers::RestorePoints(const std::vector<uint32_t>& indices, size_t skipped,
                               std::vector<Vec3d>& points) const {
  std::vector<bool> pending(points.size());
  for (const uint32_t index : indices) pending[index] = true;
  size_t left = indices.size();
  const auto take = [&](uint32_t index, Vec3d position) {
    if (!pending[index]) return;
    pending[index] = false;
    --left;
    points[index] = position;
  };
  for (size_t n = steps_.size(); n-- > 0 && left > 0;) {
    if (n == skipped) continue;
    const EditStep& step = steps_[n];
    if (step.structural.has_value()) {
      for (const uint32_t index : indices) take(index, step.positions[index]);
    }
    for (size_t m = 0; m < step.indices.size(); ++m) take(step.indices[m], step.positions[m]);
  }
  if (left == 0) return;  // always so above a structural step; the base has other indices
  for (const uint32_t index : indices) take(index, base_.base.control_points[index]);
}

void EditLayers::RebuildLattice() {
  lattice_ = base_.base;
  for (const EditStep& step : steps_) {
    if (step.structural.has_value()) lattice_ = {step.structural->structure, step.positions};
    for (size_t n = 0; n < step.indices.size(); ++n) {
      lattice_.control_points[step.indices[n]] = step.positions[n];
    }
  }
}

}  // namespace latticed
