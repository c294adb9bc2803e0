// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/paper/bezier_net/bezier_net.h"

#include <algorithm>

#include "core/ffd/plan/deform_plan.h"
#include "core/ffd/stage_matrices.h"

namespace latticed::bench {

NetTables MakeNetTables(int degree) {
  NetTables tables{.degree = degree, .m = BernsteinCount(degree), .j = {}, .k = {}, .inverse = {}};
  const std::vector<double> inverse = InverseBernsteinMatrix(degree);
  std::copy(inverse.begin(), inverse.end(), tables.inverse);
  for (int i = degree; i >= 0; --i) {
    for (int k = 0; k <= degree - i; ++k) {
      const int at = BernsteinIndex(degree, i, k);
      tables.j[at] = static_cast<uint8_t>(degree - i - k);
      tables.k[at] = static_cast<uint8_t>(k);
    }
  }
  return tables;
}

std::vector<NetPatch> MakeNetPatches(const DeformPlan& plan) {
  std::vector<NetPatch> patches;
  patches.reserve(plan.patches.size());
  for (const Patch& patch : plan.patches) {
    const bool outside = patch.box == plan.outside_box();
    const auto corner = [&](size_t c) {
      const PlanVertex& vertex = plan.vertices[patch.vertex[c]];
      return outside ? vertex.world - plan.local_origin : vertex.parameter;
    };
    const auto& span = plan.boxes[patch.box].span;
    patches.push_back({{span[0], span[1], span[2]},
                       outside ? 1 : 0,
                       corner(0),
                       corner(1) - corner(0),
                       corner(2) - corner(0)});
  }
  return patches;
}

}  // namespace latticed::bench
