// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Edits scenes, and compares them with their models once a second and after the last edit.
//
// A request of `stop` ends the edits; what was acknowledged is still compared. A scene with a fault is edited no more.
//
// Errors   those of TortureEditor and of the comparisons, naming the scene; they end the run. Faults are no errors
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_TORTURE_TORTURE_RUN_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_TORTURE_TORTURE_RUN_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "client/cpp/latticectl/torture/torture_report.h"
#include "client/cpp/library/latticed_client.h"

namespace latticed::client {

struct TorturePlan {
  int scenes = 60;
  int editors = 2;  // of each scene
  double rate = 5;  // edits a second of each editor
  double seconds = 60;
  uint32_t seed = 0;  // of all edits
};

// `scenes` are ids of scenes that nobody has edited. `new_client` makes one with its own connection; each scene has one.
// `show` is called a few times a second with a line that says how far it is.
[[nodiscard]] absl::StatusOr<TortureReport> RunTorture(
    const TorturePlan& plan, const std::vector<std::string>& scenes,
    const std::function<std::unique_ptr<Client>()>& new_client,
    const std::function<void(const std::string&)>& show, const std::stop_token& stop);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_TORTURE_TORTURE_RUN_H_
