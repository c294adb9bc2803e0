// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/client/patches/shader/shader_textures.h"

#include <numeric>

#include "client/cpp/library/patches/box_polynomials.h"
#include "core/patches/patch_places.h"

namespace latticed::testing {
namespace {

using client::BoxPolynomials;

void AddPatches(const PatchScene& scene, const BoxPolynomials& polynomials,
                ShaderTextures* textures) {
  const PatchPlan& plan = *scene.read;
  const std::vector<bool> attached = AttachedSeams(*scene.plan, scene.control_points);
  const auto is_attached = [&](const std::vector<uint32_t>& seams, uint32_t i) {
    return !seams.empty() && seams[i] != PatchPlan::kNoSeam && attached[seams[i]];
  };
  int32_t records = 0;
  for (size_t p = 0; p < plan.patches.size(); ++p) {
    const PatchPlan::Patch& patch = plan.patches[p];
    const bool inside = p < plan.inside_patches();
    std::array<uint32_t, 3> spans{};
    for (size_t a = 0; a < 3 && inside; ++a) {
      uint64_t sum = 0;
      for (const uint32_t v : patch.vertex) sum += plan.places[v][a];
      spans[a] = SpanOfPatch(sum);
    }
    bool on_seam = false;
    for (size_t c = 0; c < 3; ++c) {
      const uint32_t v = patch.vertex[c];
      const bool vertex_on_seam =
          !plan.vertex_seams.empty() && plan.vertex_seams[v] != PatchPlan::kNoSeam;
      on_seam = on_seam || (inside && vertex_on_seam);
      const Places& places = !inside && vertex_on_seam ? plan.outside_places[v] : plan.places[v];
      for (size_t a = 0; a < 3; ++a) {
        textures->patches.push_back(static_cast<int32_t>(places[a] - kPlacesPerSpan * spans[a]));
      }
      textures->patches.push_back(static_cast<int32_t>(patch.normal[c]));
    }
    int32_t above = 0;
    for (size_t a = 0; a < 3; ++a) above |= spans[a] > 0 ? 1 << a : 0;
    const auto box = static_cast<int32_t>(inside ? polynomials.Number(spans) : 0);
    textures->patches.insert(textures->patches.end(), {box, above, on_seam ? ++records : 0, 0});
    for (size_t c = 0; c < 3 && on_seam; ++c) {
      for (const uint32_t place : plan.outside_places[patch.vertex[c]]) {
        textures->seams.push_back(static_cast<int32_t>(place));
      }
      textures->seams.push_back((is_attached(plan.vertex_seams, patch.vertex[c]) ? 1 : 0) |
                                (is_attached(plan.edge_seams, patch.edge[c]) ? 2 : 0));
    }
  }
}

void AddBoxes(const PatchScene& scene, const BoxPolynomials& polynomials,
              ShaderTextures* textures) {
  const LatticeStructure& structure = scene.plan->structure;
  const KnotPlanes planes(structure);
  const std::array<size_t, 3> first{1, size_t(structure.degree[0] + 1),
                                    size_t((structure.degree[0] + 1) * (structure.degree[1] + 1))};
  const size_t terms = first[2] * size_t(structure.degree[2] + 1);
  for (uint32_t box = 0; box < polynomials.count(); ++box) {
    const size_t begin = textures->boxes.size();
    const float* c = polynomials[box].coefficients;
    for (size_t i = 0; i < terms; ++i) {
      textures->boxes.insert(textures->boxes.end(), {c[i], c[terms + i], c[2 * terms + i], 0});
    }
    for (size_t a = 0; a < 3 && box > 0; ++a) {
      const uint32_t span = (box - 1) / polynomials.step(a) % polynomials.spans(a);
      const double width = planes.upper(int(a), span) - planes.lower(int(a), span);
      textures->boxes[begin + 4 * first[a] + 3] = static_cast<float>(width);
    }
  }
}

void SetConormals(const LatticeStructure& structure, ShaderTextures* textures) {
  const auto& edges = structure.frame.edges;
  const double sign = Dot(Cross(edges[0], edges[1]), edges[2]) < 0 ? -1 : 1;
  for (int a = 0; a < 3; ++a) {
    const Vec3d f =
        edges[size_t(a)] * (sign / (structure.domain_end(a) - structure.domain_begin(a)));
    for (int c = 0; c < 3; ++c) textures->conormals[size_t(3 * a + c)] = static_cast<float>(f[c]);
  }
}

}  // namespace

ShaderTextures MakeShaderTextures(const PatchScene& scene) {
  ShaderTextures textures;
  BoxPolynomials polynomials(scene.plan->structure, scene.read->header);
  std::vector<uint32_t> all(polynomials.count() - 1);
  std::iota(all.begin(), all.end(), 1u);
  polynomials.Update(scene.control_points, all);
  for (size_t a = 0; a < 3; ++a) textures.box_steps[a] = static_cast<int32_t>(polynomials.step(a));
  AddPatches(scene, polynomials, &textures);
  AddBoxes(scene, polynomials, &textures);
  SetConormals(scene.plan->structure, &textures);
  for (const Vec3f n : scene.read->rest_normals) {
    textures.normals.insert(textures.normals.end(), {n.x, n.y, n.z, 0});
  }
  return textures;
}

}  // namespace latticed::testing
