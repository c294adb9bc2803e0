// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/plan/shared_points.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "core/base/limits.h"

namespace latticed {
namespace {

// Uses by entity: those of entity e are uses[begin[e]] .. uses[begin[e + 1] - 1], by patch.
struct UseTable {
  std::vector<uint32_t> begin;
  std::vector<PointUse> uses;
  std::span<const PointUse> Of(size_t entity) const {
    return std::span(uses).subspan(begin[entity], begin[entity + 1] - begin[entity]);
  }
};

template <typename EntityOf, typename UseOf>
UseTable MakeUseTable(size_t entities, size_t patches, EntityOf entity_of, UseOf use_of) {
  UseTable table;
  table.begin.assign(entities + 1, 0);
  for (size_t p = 0; p < patches; ++p) {
    for (size_t c = 0; c < 3; ++c) ++table.begin[entity_of(p, c) + 1];
  }
  for (size_t e = 0; e < entities; ++e) table.begin[e + 1] += table.begin[e];
  std::vector<uint32_t> next(table.begin.begin(), table.begin.end() - 1);
  table.uses.resize(3 * patches);
  for (size_t p = 0; p < patches; ++p) {
    for (size_t c = 0; c < 3; ++c) table.uses[next[entity_of(p, c)]++] = use_of(p, c);
  }
  return table;
}

UseTable VertexUses(const DeformPlan& plan) {
  return MakeUseTable(
      plan.vertices.size(), plan.patches.size(),
      [&](size_t p, size_t c) { return plan.patches[p].vertex[c]; },
      [](size_t p, size_t c) {
        return PointUse{static_cast<uint32_t>(p), static_cast<uint8_t>(c), false};
      });
}

UseTable EdgeUses(const DeformPlan& plan) {
  return MakeUseTable(
      plan.edges.size(), plan.patches.size(),
      [&](size_t p, size_t e) { return plan.patches[p].edge[e]; },
      [&](size_t p, size_t e) {
        return PointUse{static_cast<uint32_t>(p), static_cast<uint8_t>(kFirstEdgeSlot + e),
                        plan.patches[p].edge_reversed[e]};
      });
}

SharedCopy MakeCopy(const PointUse& from, const PointUse& to) {
  return {from.patch, to.patch, from.slot, to.slot, from.reversed != to.reversed};
}

}  // namespace

class SharedPointsBuilder {
 public:
  SharedPointsBuilder(const DeformPlan& plan, SharedPoints& result)
      : plan_(plan), result_(result) {}

  void Add(std::span<const PointUse> uses, uint32_t entity, uint32_t box, uint32_t seam) {
    if (uses.size() < 2) return;
    if (seam != kNoIndex) return AddSeam(uses, entity, box, seam);
    const PointUse* owner = Find(uses, [&](const PointUse& u) { return BoxOf(u) == box; });
    for (const PointUse& use : uses) {
      if (owner == nullptr) {
        result_.orphans_.push_back({use, entity, kNoIndex});
      } else if (&use != owner) {
        result_.always_.push_back(MakeCopy(*owner, use));
      }
    }
  }

 private:
  uint32_t BoxOf(const PointUse& use) const { return plan_.patches[use.patch].box; }
  bool IsOutside(const PointUse& use) const { return BoxOf(use) == plan_.outside_box(); }

  template <typename Wanted>
  static const PointUse* Find(std::span<const PointUse> uses, Wanted wanted) {
    const auto it = std::find_if(uses.begin(), uses.end(), wanted);
    return it == uses.end() ? nullptr : &*it;
  }

  // A seam has uses on both sides; `box` is the owner box inside.
  void AddSeam(std::span<const PointUse> uses, uint32_t entity, uint32_t box, uint32_t seam) {
    const PointUse* outside = Find(uses, [&](const PointUse& u) { return IsOutside(u); });
    const PointUse* inside = Find(uses, [&](const PointUse& u) { return BoxOf(u) == box; });
    for (const PointUse& use : uses) {
      if (&use != outside) {
        result_.when_attached_.push_back({seam, MakeCopy(*outside, use)});
      }
      const PointUse* owner = IsOutside(use) ? outside : inside;
      if (owner == nullptr) {
        result_.orphans_.push_back({use, entity, seam});
      } else if (&use != owner) {
        result_.when_detached_.push_back({seam, MakeCopy(*owner, use)});
      }
    }
  }

  const DeformPlan& plan_;
  SharedPoints& result_;
};

SharedPoints::SharedPoints(const DeformPlan& plan) {
  SharedPointsBuilder builder(plan, *this);
  const UseTable vertices = VertexUses(plan);
  for (size_t v = 0; v < plan.vertices.size(); ++v) {
    builder.Add(vertices.Of(v), static_cast<uint32_t>(v), plan.vertices[v].box,
                plan.vertices[v].seam);
  }
  const UseTable edges = EdgeUses(plan);
  for (size_t e = 0; e < plan.edges.size(); ++e) {
    builder.Add(edges.Of(e), static_cast<uint32_t>(e), plan.edges[e].box, plan.edges[e].seam);
  }
  ListOwners(plan.chunk_count());
}

void SharedPoints::ListOwners(size_t chunk_count) {
  constexpr uint32_t kPatches = limits::kPatchesPerChunk;
  std::vector<std::array<uint32_t, 2>> pairs;  // a chunk, and an owner
  const auto add = [&](const SharedCopy& copy) {
    const uint32_t to = copy.to_patch / kPatches, from = copy.from_patch / kPatches;
    if (from != to) pairs.push_back({to, from});
  };
  for (const SharedCopy& copy : always_) add(copy);
  for (const SeamCopy& of : when_attached_) add(of.copy);
  for (const SeamCopy& of : when_detached_) add(of.copy);
  std::ranges::sort(pairs);
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  owner_begin_.resize(chunk_count + 1);
  for (const auto& [to, from] : pairs) {
    ++owner_begin_[to + 1];
    owner_chunks_.push_back(from);
  }
  std::partial_sum(owner_begin_.begin(), owner_begin_.end(), owner_begin_.begin());
}

std::span<const uint32_t> SharedPoints::OwnerChunks(size_t chunk) const {
  return {owner_chunks_.data() + owner_begin_[chunk],
          owner_chunks_.data() + owner_begin_[chunk + 1]};
}

size_t SharedPoints::MemoryBytes() const {
  return always_.capacity() * sizeof(SharedCopy) +
         (when_attached_.capacity() + when_detached_.capacity()) * sizeof(SeamCopy) +
         orphans_.capacity() * sizeof(Orphan) +
         (owner_begin_.capacity() + owner_chunks_.capacity()) * sizeof(uint32_t);
}

}  // namespace latticed
