// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A progress bar of one line on a terminal; nothing elsewhere.
//
//   upload [##########          ]  50 %  1.00 MiB of 2.00 MiB
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_PROGRESS_BAR_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_PROGRESS_BAR_H_

#include <cstdint>
#include <string>

#include "client/cpp/latticectl/latticectl_app.h"
#include "client/cpp/library/latticed_client.h"

namespace latticed::client {

class ProgressBar {
 public:
  enum class Unit { kBytes, kCount, kNone };

  ProgressBar(Console console, std::string label, Unit unit);
  ~ProgressBar();  // wipes the line
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  void Show(uint64_t done, uint64_t total);
  // For the client's rpcs; must not outlive the bar.
  Progress callback();

 private:
  Console console_;
  std::string label_;
  Unit unit_;
  int shown_percent_ = -1;
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_PROGRESS_BAR_H_
