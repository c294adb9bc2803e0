// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Runs a load on scenes, and verifies the streams' surfaces before it returns any number.
//
// A request of `stop` ends the edits. The run still waits for their updates, verifies and reports.
//
// Errors   the first error of any stream; those of SurfaceVerifier; kCancelled if stopped before the
//          first edit
#ifndef LATTICED_CLIENT_CPP_LOAD_LOAD_RUN_H_
#define LATTICED_CLIENT_CPP_LOAD_LOAD_RUN_H_

#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/cpp/latticectl/commands/load_plan.h"
#include "client/cpp/library/latticed_client.h"
#include "client/cpp/load/load_report.h"

namespace latticed::client {

// Makes a client with its own connection.
using NewClient = std::function<std::unique_ptr<Client>()>;

// The processes whose processor time is reported.
struct LoadProcesses {
  bool own_holds_server = false;  // the server runs in this process
  int server = 0;                 // the process id of another server on this machine; 0: unknown
};

// `scenes` are ids. Progress counts the edits of all editors; its total is 0 if the plan has a
// duration.
[[nodiscard]] absl::StatusOr<LoadReport> RunLoad(
    const LoadPlan& plan, const std::vector<std::string>& scenes, const NewClient& new_client,
    const LoadProcesses& processes, const Progress& progress, const std::stop_token& stop);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LOAD_LOAD_RUN_H_
