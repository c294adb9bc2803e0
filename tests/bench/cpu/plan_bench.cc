// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Making a plan: 25,000, 50,000 and 100,000 faces, an 8 x 8 x 8 lattice of degree 2, one core.
#include <array>
#include <memory>

#include "fmt/format.h"
#include "tests/bench/benches.h"
#include "tests/bench/scenario.h"

namespace latticed::bench {
namespace {

void Plan(benchmark::State& state, int around, int across) {
  const auto mesh = MakeTorus(around, across);
  const auto lattice = Checked(FitLattice(mesh->ComputeBounds(), {8, 8, 8}, {2, 2, 2}, 0.05));
  size_t patches = 0;
  for (auto _ : state) {
    patches = Checked(MakePlan(mesh, lattice.structure))->patches.size();
  }
  state.counters["patches"] = static_cast<double>(patches);
}

}  // namespace

void RegisterPlanBenches() {
  for (const auto& [around, across] :
       {std::array{250, 100}, std::array{250, 200}, std::array{500, 200}}) {
    RegisterTimed(fmt::format("plan/{}-faces", around * across),
                  [around = around, across = across](benchmark::State& state) {
                    Plan(state, around, across);
                  });
  }
}

}  // namespace latticed::bench
