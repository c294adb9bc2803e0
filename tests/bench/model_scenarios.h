// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Sample meshes, and the models in $LATTICED_SHARED/models (../shared if it is unset), each under a
// jittered lattice of 5 x 5 x 5 control points and degree 2.
//
// Threads  one at a time
#ifndef LATTICED_TESTS_BENCH_MODEL_SCENARIOS_H_
#define LATTICED_TESTS_BENCH_MODEL_SCENARIOS_H_

#include <array>
#include <string>

#include "tests/bench/scenario.h"

namespace latticed::bench {

inline constexpr std::array kModelNames{"knot", "vase",           "fandisk", "rocker-arm",
                                        "spot", "stanford-bunny", "teapot"};

// True for samples. For models, whether the file exists.
[[nodiscard]] bool HasModel(const std::string& name);

// For a model that exists. The reference holds until another model is asked for.
[[nodiscard]] const Scenario& ModelScenario(const std::string& name);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_MODEL_SCENARIOS_H_
