// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// latticectl-store: 'latticectl store check DIR' starts it. latticectl itself knows no stores.
#include <cstdio>
#include <string>
#include <string_view>

#include "fmt/format.h"
#include "server/check/store_check.h"

namespace {

constexpr int kExitFailure = 1;
constexpr int kExitUsage = 2;

int Check(const char* folder) {
  const auto findings = latticed::CheckStore(folder);
  if (!findings.ok()) {
    fmt::print(stderr, "latticectl: {}\n", std::string(findings.status().message()));
    return kExitFailure;
  }
  fmt::print("scenes         {}\nsnapshots      {}\nrecords        {}\nmeshes         {}\n",
             findings->scenes, findings->snapshots, findings->records, findings->meshes);
  fmt::print("mesh bytes     {}\nunknown files  {}\n", findings->mesh_bytes,
             findings->unknown_files);
  for (const std::string& damage : findings->damage) fmt::print("damage         {}\n", damage);
  if (findings->damage.empty()) fmt::print("all is whole\n");
  return findings->damage.empty() ? 0 : kExitFailure;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 3 && std::string_view(argv[1]) == "check") return Check(argv[2]);
  fmt::print(stderr, "usage: latticectl-store check FOLDER\n");
  return kExitUsage;
}
