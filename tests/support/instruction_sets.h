// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Steers Highway's run-time dispatch, to test code that is compiled once per instruction set under each
// set that the machine has.
#ifndef LATTICED_TESTS_SUPPORT_INSTRUCTION_SETS_H_
#define LATTICED_TESTS_SUPPORT_INSTRUCTION_SETS_H_

#include <cstdint>
#include <vector>

#include "hwy/targets.h"

namespace latticed::testing {

// Makes run-time dispatch choose `target` until the object goes out of scope.
class ChosenTarget {
 public:
  explicit ChosenTarget(int64_t target) { hwy::GetChosenTarget().Update(target); }
  ~ChosenTarget() {
    static const int64_t all = hwy::SupportedTargets();  // in a virtual machine, asking takes 50 us
    hwy::GetChosenTarget().Update(all);
  }
  ChosenTarget(const ChosenTarget&) = delete;  // dispatch is process-wide
  ChosenTarget& operator=(const ChosenTarget&) = delete;
};

// The kernels' instruction sets that this machine has, best first; the last is the baseline.
inline std::vector<int64_t> Targets() {
  const int64_t supported = hwy::SupportedTargets();
  std::vector<int64_t> targets;
  for (const int64_t target : {int64_t{HWY_AVX3}, int64_t{HWY_AVX2}}) {
    if (supported & target) targets.push_back(target);
  }
  targets.push_back(HWY_STATIC_TARGET);
  return targets;
}

// The same with those that the encoder's kernels leave out.
inline std::vector<int64_t> AllTargets() {
  std::vector<int64_t> targets = Targets();
  if (hwy::SupportedTargets() & HWY_SSSE3) targets.insert(targets.end() - 1, HWY_SSSE3);
  return targets;
}

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SUPPORT_INSTRUCTION_SETS_H_
