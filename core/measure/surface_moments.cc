// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/measure/surface_moments.h"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "core/base/status_macros.h"

namespace latticed {
namespace {

// Triangles that are expanded side by side.
constexpr size_t kTriangles = 4;
// Groups of triangles that are summed before they join the box's sum: long sums lose digits.
constexpr size_t kGroupsPerSum = 64;

struct Lanes {
  std::array<double, kTriangles> value{};
};

// kTriangles triangles: l of their corners, and their directed areas.
struct TriangleGroup {
  std::array<std::array<Lanes, 3>, 3> corner;  // [corner][axis]
  std::array<Lanes, 3> weight;                 // [corner]
  std::array<Lanes, 6> area;  // (1, 2), (2, 0), (0, 1), then (0, w), (1, w), (2, w)
};

// The factor w^power, and where the directed areas begin.
struct Family {
  size_t power, area;
};
constexpr std::array<Family, 1> kPlainFamilies = {{{0, 0}}};
constexpr std::array<Family, SurfaceMoments::kWeightedFamilies> kWeightedFamilies = {
    {{1, 0}, {2, 0}, {3, 0}, {1, 3}, {2, 3}}};
constexpr size_t kWeightPowers = 4;

std::span<const Family> FamiliesOf(bool weighted) {
  return weighted ? std::span<const Family>(kWeightedFamilies)
                  : std::span<const Family>(kPlainFamilies);
}

size_t CountFilled(const DeformPlan& plan) {
  size_t filled = 0;
  for (uint32_t box = 0; box < plan.outside_box(); ++box) {
    filled += plan.box_patches[box] != plan.box_patches[box + 1] ? 1u : 0u;
  }
  return filled;
}

SurfaceMoments::Order OrderOf(const DeformPlan& plan, SurfaceMoments::Order order) {
  return plan.is_weighted() ? SurfaceMoments::Order::kVolume : order;
}

std::array<size_t, 3> ExtentOf(const DeformPlan& plan, SurfaceMoments::Order order) {
  std::array<size_t, 3> extent;
  for (size_t a = 0; a < 3; ++a) {
    extent[a] =
        static_cast<size_t>(static_cast<int>(OrderOf(plan, order)) * plan.structure.degree[a]) + 1;
  }
  return extent;
}

// Of all families of all filled boxes.
size_t TableBytes(const std::array<size_t, 3>& extent, size_t families, size_t filled) {
  return 3 * families * filled * extent[0] * extent[1] * extent[2] * sizeof(double);
}

// Fewer patches are integrated faster one by one, and tables of many boxes would take more memory than the scene.
bool HasWeightedTables(const DeformPlan& plan) {
  constexpr size_t kPatchesPerBox = 4;
  if (!plan.is_weighted() || !plan.turned.empty()) return false;
  const size_t filled = CountFilled(plan);
  return plan.patches.size() - plan.outside_patches >= kPatchesPerBox * filled &&
         TableBytes(ExtentOf(plan, SurfaceMoments::Order::kVolume), kWeightedFamilies.size(),
                    filled) <= SurfaceMoments::kMostWeightedBytes;
}

// Whether the volume is integrated patch by patch (patch_integrals.h), without moments.
bool IsByPatches(const DeformPlan& plan) {
  return !plan.turned.empty() || (plan.is_weighted() && !HasWeightedTables(plan));
}

size_t FamilyCount(const DeformPlan& plan) { return FamiliesOf(HasWeightedTables(plan)).size(); }

std::vector<uint32_t> FilledBoxes(const DeformPlan& plan) {
  std::vector<uint32_t> boxes;
  if (IsByPatches(plan)) return boxes;
  for (uint32_t box = 0; box < plan.outside_box(); ++box) {
    if (plan.box_patches[box] != plan.box_patches[box + 1]) boxes.push_back(box);
  }
  return boxes;
}

// The series of 1 / ((1 - a.z)(1 - b.z)(1 - c.z)). A border of zeros before each axis saves the tests for its begin. The
// powers of weights, if there are any, come before those of the axes.
class Series {
 public:
  Series(const std::array<size_t, 3>& extent, size_t weight_powers)
      : extent_(extent),
        weight_powers_(weight_powers),
        step_{(extent[1] + 1) * (extent[2] + 1), extent[2] + 1, 1},
        of_power_((extent[0] + 1) * step_[0]),
        terms_(weight_powers * of_power_) {}

  void Expand(const TriangleGroup& group) {
    std::ranges::fill(terms_, Lanes{});
    terms_[At(0, 0, 0)].value.fill(1);
    for (size_t c = 0; c < 3; ++c) {
      Multiply<false>(group.corner[c], {}, 0);
      for (size_t s = 1; s < weight_powers_; ++s) {
        Multiply<true>(group.corner[c], group.weight[c], s);
      }
    }
  }
  size_t At(size_t p, size_t q, size_t r) const {
    return (p + 1) * step_[0] + (q + 1) * step_[1] + (r + 1);
  }
  const Lanes* row(size_t s, size_t p, size_t q) const {
    return terms_.data() + s * of_power_ + At(p, q, 0);
  }

 private:
  template <bool kWeighted>
  void Multiply(const std::array<Lanes, 3>& v, const Lanes& weight, size_t s) {
    for (size_t p = 0; p < extent_[0]; ++p) {
      for (size_t q = 0; q < extent_[1]; ++q) {
        Lanes* term = terms_.data() + s * of_power_ + At(p, q, 0);
        const Lanes *before_p = term - step_[0], *before_q = term - step_[1];
        const Lanes* before_s = kWeighted ? term - of_power_ : nullptr;
        Lanes last;
        for (size_t r = 0; r < extent_[2]; ++r) {
          for (size_t i = 0; i < kTriangles; ++i) {
            last.value[i] = term[r].value[i] + v[0].value[i] * before_p[r].value[i] +
                            v[1].value[i] * before_q[r].value[i] + v[2].value[i] * last.value[i];
            if constexpr (kWeighted) last.value[i] += weight.value[i] * before_s[r].value[i];
          }
          term[r] = last;
        }
      }
    }
  }

  const std::array<size_t, 3> extent_;
  const size_t weight_powers_;
  const std::array<size_t, 3> step_;
  const size_t of_power_;
  std::vector<Lanes> terms_;
};

// Up to kTriangles patches of a box. Those that are missing have no area.
TriangleGroup GroupOf(const DeformPlan& plan, uint32_t box, size_t first, size_t count) {
  const KnotBox& cell = plan.boxes[box];
  const Vec3d centre = 0.5 * (cell.lower + cell.upper), width = cell.upper - cell.lower;
  TriangleGroup group{};
  for (size_t i = 0; i < count; ++i) {
    std::array<Vec3d, 3> l;
    for (size_t c = 0; c < 3; ++c) {
      const Vec3d at = plan.vertices[plan.patches[first + i].vertex[c]].parameter - centre;
      for (int a = 0; a < 3; ++a) {
        l[c][a] = at[a] / width[a];
        group.corner[c][static_cast<size_t>(a)].value[i] = l[c][a];
      }
    }
    const Vec3d area = 0.5 * Cross(l[1] - l[0], l[2] - l[0]);
    for (int a = 0; a < 3; ++a) group.area[static_cast<size_t>(a)].value[i] = area[a];
    if (!plan.is_weighted()) continue;
    const std::array<double, 3> w = plan.CornerWeights(first + i);
    const Vec3d across = 0.5 * ((w[2] - w[0]) * (l[1] - l[0]) - (w[1] - w[0]) * (l[2] - l[0]));
    for (size_t a = 0; a < 3; ++a) {
      group.weight[a].value[i] = w[a];
      group.area[3 + a].value[i] = across[static_cast<int>(a)];
    }
  }
  return group;
}

// Adds to the three tables of a family.
void AddGroup(const TriangleGroup& group, const Series& series, const Family& family,
              const std::array<size_t, 3>& extent, double* tables) {
  const size_t terms = extent[0] * extent[1] * extent[2];
  for (size_t p = 0; p < extent[0]; ++p) {
    for (size_t q = 0; q < extent[1]; ++q) {
      const Lanes* row = series.row(family.power, p, q);
      for (size_t r = 0; r < extent[2]; ++r, ++tables) {
        for (size_t d = 0; d < 3; ++d) {
          const Lanes& area = group.area[family.area + d];
          double total = 0;
          for (size_t i = 0; i < kTriangles; ++i) total += area.value[i] * row[r].value[i];
          tables[d * terms] += total;
        }
      }
    }
  }
}

double Factorial(size_t n) {
  double product = 1;
  for (size_t i = 2; i <= n; ++i) product *= static_cast<double>(i);
  return product;
}

}  // namespace

SurfaceMoments::SurfaceMoments(std::shared_ptr<const DeformPlan> plan, Order order)
    : plan_(std::move(plan)),
      order_(OrderOf(*plan_, order)),
      families_(FamilyCount(*plan_)),
      extent_(ExtentOf(*plan_, order)),
      boxes_(FilledBoxes(*plan_)),
      moments_(3 * families_ * boxes_.size() * terms() + kOverhang) {
  const LatticeStructure& s = plan_->structure;
  for (size_t a = 0; a < 3; ++a) {
    basis_[a].resize(static_cast<size_t>(s.size[a]));
    for (int span = s.degree[a]; span < s.size[a]; ++span) {
      const auto k = static_cast<size_t>(span);
      if (s.knots[a][k + 1] > s.knots[a][k]) {
        basis_[a][k] = MakeSpanBasis(s.knots[a], s.degree[a], span);
      }
    }
  }
}

size_t SurfaceMoments::BytesFor(const DeformPlan& plan, Order order) {
  const auto extent = ExtentOf(plan, order);
  size_t spans = 0;
  for (const int size : plan.structure.size) spans += static_cast<size_t>(size);
  const size_t boxes = FilledBoxes(plan).size();
  return sizeof(SurfaceMoments) + spans * sizeof(SpanBasis) + boxes * sizeof(uint32_t) +
         TableBytes(extent, FamilyCount(plan), boxes) + kOverhang * sizeof(double);
}

absl::StatusOr<std::shared_ptr<const SurfaceMoments>> SurfaceMoments::Make(
    std::shared_ptr<const DeformPlan> plan, Order order, StopCheck stop) {
  const std::shared_ptr<SurfaceMoments> moments(new SurfaceMoments(std::move(plan), order));
  StopPoll poll(stop);
  for (size_t n = 0; n < moments->boxes_.size(); ++n) {
    LATTICED_RETURN_IF_ERROR(moments->AddBox(n, poll));
  }
  moments->AddOutside();
  if (moments->has_weights()) moments->AddRestVolume();
  return moments;
}

absl::Status SurfaceMoments::AddBox(size_t n, StopPoll& poll) {
  const uint32_t box = boxes_[n];
  const size_t end = plan_->box_patches[box + 1];
  const std::span<const Family> families = FamiliesOf(has_weights());
  Series series(extent_, has_weights() ? kWeightPowers : 1);
  std::vector<double> sum(3 * families_ * terms());
  double* const tables = moments_.data() + n * sum.size();
  const auto flush = [&] {
    for (size_t i = 0; i < sum.size(); ++i) tables[i] += sum[i];
    std::ranges::fill(sum, 0);
  };
  size_t groups = 0;
  for (size_t first = plan_->box_patches[box]; first < end; first += kTriangles) {
    LATTICED_RETURN_IF_ERROR(poll.Step(kTriangles));
    const TriangleGroup group = GroupOf(*plan_, box, first, std::min(kTriangles, end - first));
    series.Expand(group);
    for (size_t f = 0; f < families_; ++f) {
      AddGroup(group, series, families[f], extent_, sum.data() + 3 * f * terms());
    }
    if (++groups % kGroupsPerSum == 0) flush();
  }
  flush();
  ScaleTables(tables);
  return absl::OkStatus();
}

void SurfaceMoments::ScaleTables(double* tables) const {
  for (const Family& family : FamiliesOf(has_weights())) {
    const size_t s = family.power;
    for (size_t p = 0; p < extent_[0]; ++p) {
      for (size_t q = 0; q < extent_[1]; ++q) {
        for (size_t r = 0; r < extent_[2]; ++r, ++tables) {
          const double scale = 2 * Factorial(p) * Factorial(q) * Factorial(r) * Factorial(s) /
                               Factorial(p + q + r + s + 2);
          for (size_t d = 0; d < 3; ++d) tables[d * terms()] *= scale;
        }
      }
    }
    tables += 2 * terms();
  }
}

void SurfaceMoments::AddRestVolume() {
  for (const Patch& patch : plan_->patches) {
    std::array<Vec3d, 3> x;
    for (size_t c = 0; c < 3; ++c)
      x[c] = plan_->vertices[patch.vertex[c]].world - plan_->local_origin;
    rest_volume_ += Dot(x[0], Cross(x[1] - x[0], x[2] - x[0])) / 6;
  }
}

void SurfaceMoments::AddOutside() {
  const DeformPlan& plan = *plan_;
  for (size_t p = plan.box_patches[plan.outside_box()]; p < plan.patches.size(); ++p) {
    std::array<Vec3d, 3> x;
    for (size_t c = 0; c < 3; ++c) {
      x[c] = plan.vertices[plan.patches[p].vertex[c]].world - plan.local_origin;
    }
    const double volume = 0.5 * Dot(x[0], Cross(x[1] - x[0], x[2] - x[0]));
    outside_volume_ += volume;
    outside_centroid_ += (volume / 3) * (x[0] + x[1] + x[2]);
  }
}

}  // namespace latticed
