// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Runs a load on scenes, and verifies the streams' surfaces before it reports a number.
//
//   LoadRun run(plan, scenes, new_client, stop);
//   const auto report = run.Run(progress);
//
// A request of `stop` ends the edits. The run then still settles, verifies and reports.
//
// Errors   the first of any stream, SurfaceVerifier's; kCancelled when stopped before the first edit
// Threads  one at a time
#ifndef LATTICED_CLIENT_CPP_LOAD_LOAD_RUN_H_
#define LATTICED_CLIENT_CPP_LOAD_LOAD_RUN_H_

#include <cstdint>
#include <memory>
#include <stop_token>
#include <vector>

#include "absl/status/statusor.h"
#include "client/cpp/library/latticed_client.h"
#include "client/cpp/load/load_control.h"
#include "client/cpp/load/load_plan.h"
#include "client/cpp/load/load_report.h"
#include "client/cpp/load/scene_load.h"

namespace latticed::client {

class LoadRun {
 public:
  struct Options {
    bool fused = true;           // the scenes' pipeline
    bool server_inside = false;  // of this process
    int server_process = 0;      // its id, where it runs on this machine and is known
  };

  LoadRun(const LoadPlan& plan, const std::vector<LoadScene>& scenes,
          const SceneLoad::NewClient& new_client, const Options& options,
          const std::stop_token& stop);
  // Progress counts edits of all editors, or milliseconds where the duration ends the run.
  [[nodiscard]] absl::StatusOr<LoadReport> Run(const Progress& progress);

 private:
  absl::Status Prepare();
  void Measure(const Progress& progress);
  absl::Status Settle();
  // Counters that grow during the run.
  struct Counters {
    CpuTimes cpu;
    uint64_t superseded = 0;
  };
  absl::StatusOr<Counters> ReadCounters() const;

  const LoadPlan plan_;
  const Options options_;
  const std::unique_ptr<Client> client_;
  LoadControl control_;
  std::vector<std::unique_ptr<SceneLoad>> scenes_;  // use plan_ and control_
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LOAD_LOAD_RUN_H_
