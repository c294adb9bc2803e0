// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/patches/patch_plan_reader.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "core/codec/octahedral.h"
#include "core/patches/byte_planes.h"
#include "core/patches/zlib_stream.h"
#include "fmt/format.h"

namespace latticed {
namespace {

absl::Status CheckCount(std::string_view field, uint64_t got, uint64_t header) {
  if (got == header) return absl::OkStatus();
  return error::InvalidField(field, fmt::format("has {}, its header says {}", got, header));
}

// Reads numbers that are 0 for what is new, else how far back they are.
class UseReader {
 public:
  UseReader(size_t before, uint32_t fresh)
      : next_(static_cast<uint32_t>(before)), end_(next_ + fresh) {}

  // False for a code that names nothing.
  bool Read(uint32_t code, uint32_t* number) {
    if (code > next_ || (code == 0 && next_ == end_)) return false;
    *number = code == 0 ? next_++ : next_ - code;
    return true;
  }
  bool AtEnd() const { return next_ == end_; }

 private:
  uint32_t next_, end_;
};

bool IsAscending(const std::vector<uint32_t>& numbers) {
  return std::adjacent_find(numbers.begin(), numbers.end(), std::greater_equal<>()) ==
         numbers.end();
}

template <typename T>
void Append(const std::vector<T>& from, std::vector<T>* to) {
  to->insert(to->end(), from.begin(), from.end());
}

}  // namespace

PatchPlanReader::PatchPlanReader(const PatchPlanHeader& header) { plan_.header = header; }

absl::Status PatchPlanReader::CheckHeader() const {
  const PatchPlanHeader& header = plan_.header;
  if (header.patches_outside > header.patch_count || header.patch_count > limits::kMaxPatches) {
    return error::InvalidField("header.patch_count",
                               "is smaller than patches_outside, or too large");
  }
  if (!IsFinite(header.origin)) return error::NotFinite("header.origin");
  if (!(header.curvature_unit > 0)) {
    return error::InvalidField("header.curvature_unit", "is not above 0");
  }
  return absl::OkStatus();
}

absl::Status PatchPlanReader::CheckRun(const PatchRun& run) const {
  const PatchPlanHeader& header = plan_.header;
  const uint64_t first = plan_.patches.size(), inside = header.patch_count - header.patches_outside;
  if (run.first_patch != first) {
    return error::InvalidField("run.first_patch",
                               fmt::format("is {}, {} comes next", run.first_patch, first));
  }
  const uint64_t end = first + run.patches, last = first < inside ? inside : header.patch_count;
  if (run.patches == 0 || run.patches > kMaxRunPatches || end > last) {
    return error::InvalidField("run.patches",
                               fmt::format("{} patches after {} of {}", run.patches, first, last));
  }
  if (run.new_vertices > 3 * run.patches) {
    return error::InvalidField("run.new_vertices", "is more than three per patch");
  }
  if (run.new_normals > RestNormalsPerPatch(header.normals) * run.patches) {
    return error::InvalidField("run.new_normals", "is more than the patches use");
  }
  return absl::OkStatus();
}

absl::Status PatchPlanReader::Add(const PatchRun& run) {
  LATTICED_RETURN_IF_ERROR(CheckHeader());
  LATTICED_RETURN_IF_ERROR(CheckRun(run));
  const RestNormals normals = plan_.header.normals;
  const size_t corner_bytes = size_t{12} * run.patches, place_bytes = size_t{12} * run.new_vertices;
  const size_t use_bytes = 4 * RestNormalsPerPatch(normals) * run.patches;
  const size_t rest_bytes = 2 * NumbersPerRestNormal(normals) * run.new_normals;
  const size_t slope_bytes = normals == RestNormals::kNone ? 0 : size_t{12} * run.patches;
  const size_t weight_bytes =
      plan_.header.weighted ? size_t{2} * run.new_vertices + slope_bytes : 0;
  LATTICED_ASSIGN_OR_RETURN(
      const std::string inflated,
      Inflate("run.data", run.data,
              corner_bytes + place_bytes + use_bytes + rest_bytes + weight_bytes));
  std::string_view bytes = inflated;
  const size_t first_patch = plan_.patches.size();
  plan_.patches.resize(first_patch + run.patches);
  LATTICED_RETURN_IF_ERROR(ReadCorners(bytes, run.patches, run.new_vertices));
  bytes.remove_prefix(corner_bytes);
  ReadPlaces(bytes, run.new_vertices);
  bytes.remove_prefix(place_bytes);
  LATTICED_RETURN_IF_ERROR(ReadNormals(bytes, run.patches, run.new_normals));
  bytes.remove_prefix(use_bytes);
  ReadRestNormals(bytes, run.new_normals);
  bytes.remove_prefix(rest_bytes);
  LATTICED_RETURN_IF_ERROR(ReadWeights(bytes, run.new_vertices, run.patches));
  NumberEdges(first_patch);
  return absl::OkStatus();
}

absl::Status PatchPlanReader::ReadCorners(std::string_view bytes, uint32_t patches,
                                          uint32_t new_vertices) {
  UseReader reader(plan_.places.size(), new_vertices);
  const size_t first = plan_.patches.size() - patches;
  for (size_t i = 0; i < size_t{3} * patches; ++i) {
    const auto code = BytePlanesNumber<uint32_t>(bytes, size_t{3} * patches, i);
    if (!reader.Read(code, &plan_.patches[first + i / 3].vertex[i % 3])) {
      return error::InvalidField("run.data", fmt::format("corner {} has no vertex", i));
    }
  }
  if (!reader.AtEnd())
    return error::InvalidField("run.new_vertices", "is more than the patches use");
  return absl::OkStatus();
}

void PatchPlanReader::ReadPlaces(std::string_view bytes, uint32_t count) {
  const size_t first = plan_.places.size();
  plan_.places.resize(first + count);
  for (size_t a = 0; a < 3; ++a) {
    uint32_t place = 0;
    for (size_t i = 0; i < count; ++i) {
      place = DecodeDifference(place,
                               BytePlanesNumber<uint32_t>(bytes, size_t{3} * count, a * count + i));
      plan_.places[first + i][a] = place;
    }
  }
}

absl::Status PatchPlanReader::ReadNormals(std::string_view bytes, uint32_t patches,
                                          uint32_t new_normals) {
  const size_t per_patch = RestNormalsPerPatch(plan_.header.normals),
               first = plan_.patches.size() - patches;
  if (per_patch == 0) return absl::OkStatus();
  UseReader reader(plan_.rest_normals.size(), new_normals);
  for (size_t i = 0; i < per_patch * patches; ++i) {
    uint32_t normal = 0;
    if (!reader.Read(BytePlanesNumber<uint32_t>(bytes, per_patch * patches, i), &normal)) {
      return error::InvalidField("run.data", fmt::format("normal {} is none", i));
    }
    auto& of_patch = plan_.patches[first + i / per_patch].normal;
    if (per_patch == 1)
      of_patch = {normal, normal, normal};
    else
      of_patch[i % 3] = normal;
  }
  if (!reader.AtEnd())
    return error::InvalidField("run.new_normals", "is more than the patches use");
  return absl::OkStatus();
}

absl::Status PatchPlanReader::ReadWeights(std::string_view bytes, uint32_t vertices,
                                          uint32_t patches) {
  if (!plan_.header.weighted) return absl::OkStatus();
  for (size_t i = 0; i < vertices; ++i) {
    plan_.weights.push_back(BytePlanesNumber<uint16_t>(bytes, vertices, i));
  }
  bytes.remove_prefix(size_t{2} * vertices);
  if (plan_.header.normals == RestNormals::kNone) return absl::OkStatus();
  const size_t count = size_t{3} * patches;
  const auto component = [&](size_t a, size_t i) {
    return std::bit_cast<float>(BytePlanesNumber<uint32_t>(bytes, count, a * patches + i));
  };
  for (size_t i = 0; i < patches; ++i) {
    const Vec3f slope{component(0, i), component(1, i), component(2, i)};
    if (!IsFinite(ToDouble(slope))) return error::NotFinite("run.data");
    plan_.slopes.push_back(slope);
  }
  return absl::OkStatus();
}

void PatchPlanReader::ReadRestNormals(std::string_view bytes, uint32_t count) {
  const RestNormals normals = plan_.header.normals;
  const size_t numbers = NumbersPerRestNormal(normals) * count;
  const auto number = [&](size_t component, size_t i) {
    return BytePlanesNumber<uint16_t>(bytes, numbers, component * count + i);
  };
  for (size_t i = 0; i < count; ++i) {
    if (normals == RestNormals::kFacet) {
      const int32_t top = OctahedralMax(kRestNormalBits);
      plan_.rest_normals.push_back(DequantiseNormal(
          {std::min<int32_t>(number(0, i), top), std::min<int32_t>(number(1, i), top)},
          kRestNormalBits));
      continue;
    }
    const auto component = [&](size_t c) {
      return static_cast<float>(static_cast<int16_t>(number(c, i)) / kRestNormalUnit);
    };
    plan_.rest_normals.push_back({component(0), component(1), component(2)});
  }
}

void PatchPlanReader::NumberEdges(size_t first_patch) {
  for (size_t p = first_patch; p < plan_.patches.size(); ++p) {
    PatchPlan::Patch& patch = plan_.patches[p];
    for (size_t e = 0; e < 3; ++e) {
      const auto [low, high] = std::minmax(patch.vertex[e], patch.vertex[(e + 1) % 3]);
      const auto [number, added] = edge_numbers_.TryEmplace(low, high, edges_);
      patch.edge[e] = number;
      if (added) ++edges_;
    }
  }
}

absl::Status PatchPlanReader::Add(const PatchSeams& seams) {
  if (plan_.patches.size() != plan_.header.patch_count) {
    return error::InvalidField("seams", "come before the last run");
  }
  Append(seams.ranges, &seams_.ranges);
  Append(seams.vertices, &seams_.vertices);
  Append(seams.vertex_seams, &seams_.vertex_seams);
  Append(seams.outside_places, &seams_.outside_places);
  Append(seams.edges, &seams_.edges);
  Append(seams.edge_seams, &seams_.edge_seams);
  Append(seams.identity_points, &seams_.identity_points);
  return absl::OkStatus();
}

absl::Status PatchPlanReader::CheckSeams() const {
  if (seams_.ranges.size() % 6 != 0)
    return error::InvalidField("seams.ranges", "has no six per seam");
  const size_t seams = seams_.ranges.size() / 6;
  const auto check = [seams](std::string_view of, const std::vector<uint32_t>& numbers,
                             size_t count, const std::vector<uint32_t>& of_seam) {
    const bool known = numbers.empty() || (IsAscending(numbers) && numbers.back() < count);
    const bool paired =
        of_seam.size() == numbers.size() &&
        std::all_of(of_seam.begin(), of_seam.end(), [seams](uint32_t s) { return s < seams; });
    return known && paired ? absl::OkStatus()
                           : error::InvalidField(fmt::format("seams.{}", of),
                                                 "do not ascend, or name what is not there");
  };
  LATTICED_RETURN_IF_ERROR(
      check("vertices", seams_.vertices, plan_.places.size(), seams_.vertex_seams));
  LATTICED_RETURN_IF_ERROR(check("edges", seams_.edges, edges_, seams_.edge_seams));
  LATTICED_RETURN_IF_ERROR(
      CheckCount("seams.outside_places", seams_.outside_places.size(), 3 * seams_.vertices.size()));
  if (seams_.identity_points.size() % 3 != 0 || (seams > 0 && seams_.identity_points.empty())) {
    return error::InvalidField("seams.identity_points", "has no x, y, z per control point");
  }
  return absl::OkStatus();
}

void PatchPlanReader::MoveSeams() {
  for (size_t i = 0; i < seams_.ranges.size(); i += 6) {
    auto& range = plan_.seam_ranges.emplace_back();
    std::copy_n(seams_.ranges.begin() + static_cast<ptrdiff_t>(i), 6, range.begin());
  }
  if (plan_.seam_ranges.empty()) return;
  plan_.vertex_seams.assign(plan_.places.size(), PatchPlan::kNoSeam);
  plan_.outside_places.resize(plan_.places.size());
  for (size_t i = 0; i < seams_.vertices.size(); ++i) {
    const uint32_t v = seams_.vertices[i];
    plan_.vertex_seams[v] = seams_.vertex_seams[i];
    std::copy_n(seams_.outside_places.begin() + static_cast<ptrdiff_t>(3 * i), 3,
                plan_.outside_places[v].begin());
  }
  plan_.edge_seams.assign(edges_, PatchPlan::kNoSeam);
  for (size_t i = 0; i < seams_.edges.size(); ++i)
    plan_.edge_seams[seams_.edges[i]] = seams_.edge_seams[i];
  for (size_t i = 0; i < seams_.identity_points.size(); i += 3) {
    const double* x = &seams_.identity_points[i];
    plan_.identity_points.push_back({x[0], x[1], x[2]});
  }
}

// Patches outside the frame take a vertex on a seam from its outside places. So does a patch inside with an edge on an
// attached seam: both ends of such an edge are on a seam.
absl::Status PatchPlanReader::CheckOutside() const {
  const auto on_seam = [&](uint32_t v) {
    return !plan_.vertex_seams.empty() && plan_.vertex_seams[v] != PatchPlan::kNoSeam;
  };
  const auto in_box = [](const Places& places) {
    return std::all_of(places.begin(), places.end(),
                       [](uint32_t place) { return place <= kPlacesPerSpan; });
  };
  for (size_t p = 0; p < plan_.patches.size(); ++p) {
    const PatchPlan::Patch& patch = plan_.patches[p];
    for (size_t e = 0; e < 3; ++e) {
      const uint32_t v = patch.vertex[e], next = patch.vertex[(e + 1) % 3];
      if (on_seam(v) && !in_box(plan_.outside_places[v])) {
        return error::InvalidField("seams.outside_places", "leave the outside box");
      }
      if (p >= plan_.inside_patches() && !on_seam(v) && !in_box(plan_.places[v])) {
        return error::InvalidField("run.data", fmt::format("patch {} leaves the outside box", p));
      }
      const bool seam_edge =
          !plan_.edge_seams.empty() && plan_.edge_seams[patch.edge[e]] != PatchPlan::kNoSeam;
      if (seam_edge && !(on_seam(v) && on_seam(next))) {
        return error::InvalidField("seams.edges",
                                   fmt::format("patch {} has an end without a seam", p));
      }
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<PatchPlan> PatchPlanReader::Finish() {
  LATTICED_RETURN_IF_ERROR(CheckHeader());  // there may have been no run
  const PatchPlanHeader& header = plan_.header;
  LATTICED_RETURN_IF_ERROR(CheckCount("patch_count", plan_.patches.size(), header.patch_count));
  LATTICED_RETURN_IF_ERROR(CheckCount("vertex_count", plan_.places.size(), header.vertex_count));
  LATTICED_RETURN_IF_ERROR(CheckCount("edge_count", edges_, header.edge_count));
  LATTICED_RETURN_IF_ERROR(
      CheckCount("normal_count", plan_.rest_normals.size(), header.normal_count));
  LATTICED_RETURN_IF_ERROR(CheckSeams());
  MoveSeams();
  LATTICED_RETURN_IF_ERROR(CheckOutside());
  return std::exchange(plan_, {});
}

}  // namespace latticed
