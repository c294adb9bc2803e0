// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The command line of 'latticectl bench'. Only the load generator parses it (client/cpp/load); latticectl has it in its
// manual page and completes it.
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_COMMANDS_BENCH_FLAGS_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_COMMANDS_BENCH_FLAGS_H_

#include <string>
#include <vector>

#include "client/cpp/latticectl/commands/load_plan.h"
#include "client/cpp/latticectl/geometry/lattice_json.h"
#include "client/cpp/latticectl/session/session.h"
#include "core/mesh/sample_meshes.h"
#include "latticed/v1/scene.pb.h"

namespace CLI {
class App;
}

namespace latticed::client {

struct BenchFlags {
  SessionFlags session;
  std::vector<std::string> meshes{"knot"};
  int resolution = kDefaultSampleResolution;
  FitFlags fit;
  v1::Pipeline pipeline = v1::PIPELINE_UNSPECIFIED;
  int server_process = 0;
  bool json = false;
  LoadPlan plan;
};

inline constexpr char kBenchExample[] =
    "bench knot --editors 2 --edits 200 --server 127.0.0.1:50151";

// Declares what 'latticectl bench' does and takes. Parsing writes to `flags`.
void DeclareBench(CLI::App& bench, BenchFlags& flags);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_COMMANDS_BENCH_FLAGS_H_
