// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// For what another thread or process does a little later.
#ifndef LATTICED_TESTS_SUPPORT_BECOMES_H_
#define LATTICED_TESTS_SUPPORT_BECOMES_H_

#include <chrono>
#include <functional>
#include <thread>

namespace latticed::testing {

// Whether the condition holds at one of so many looks, 10 ms apart.
inline bool Becomes(int looks, const std::function<bool()>& condition) {
  for (int i = 0; i < looks; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SUPPORT_BECOMES_H_
