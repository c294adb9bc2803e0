// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Runs the steps of bezier_net.h on the host in order, for tests without a device. Returns the nets
// as the kernel makes them.
#ifndef LATTICED_TESTS_BENCH_PAPER_BEZIER_NET_BEZIER_NETS_ON_HOST_H_
#define LATTICED_TESTS_BENCH_PAPER_BEZIER_NET_BEZIER_NETS_ON_HOST_H_

#include <memory>
#include <span>
#include <vector>

#include "core/ffd/plan/deform_plan.h"
#include "tests/bench/paper/bezier_net/bezier_net.h"

namespace latticed::bench {

[[nodiscard]] inline std::vector<NetPoint> BezierNetsOnHost(const DeformPlan& plan,
                                                            std::span<const Vec3d> control_points) {
  std::vector<Vec3d> relative(control_points.begin(), control_points.end());
  for (Vec3d& p : relative) p -= plan.local_origin;
  const std::vector<NetPatch> patches = MakeNetPatches(plan);
  const NetTables tables = MakeNetTables(plan.structure.patch_degree());
  std::vector<NetPoint> nets(patches.size() * static_cast<size_t>(tables.m + 1));
  NetJob job{.patches = patches.data(),
             .count = patches.size(),
             .volume = {.control_points = relative.data()},
             .tables = &tables,
             .nets = nets.data()};
  for (size_t a = 0; a < 3; ++a) {
    job.volume.degree[a] = plan.structure.degree[a];
    job.volume.size[a] = plan.structure.size[a];
    job.volume.knots[a] = plan.structure.knots[a].data();
  }
  const auto group = std::make_unique<NetGroup>();
  for (size_t first = 0; first < job.count; first += kNetGroup) {
    for (int i = 0; i < kNetGroup * tables.m; ++i) NetSample(job, first, i, *group);
    for (int i = 0; i < kNetGroup * tables.m; ++i) NetControl(job, first, i, *group);
  }
  return nets;
}

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_PAPER_BEZIER_NET_BEZIER_NETS_ON_HOST_H_
