// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Waits for something that another thread or process does a little later.
#ifndef LATTICED_TESTS_SUPPORT_BECOMES_H_
#define LATTICED_TESTS_SUPPORT_BECOMES_H_

#include <chrono>
#include <functional>
#include <thread>

namespace latticed::testing {

// Tests the condition up to `looks` times, with pauses of 10 ms. Returns whether it became true.
inline bool Becomes(int looks, const std::function<bool()>& condition) {
  for (int i = 0; i < looks; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SUPPORT_BECOMES_H_
