// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/model_scenarios.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <utility>

#include "core/mesh/mesh_io.h"
#include "core/mesh/sample_meshes.h"

namespace latticed::bench {
namespace {

bool IsSample(const std::string& name) {
  return std::ranges::find(SampleMeshNames(), name) != SampleMeshNames().end();
}

std::filesystem::path ModelPath(const std::string& name) {
  const char* shared = std::getenv("LATTICED_SHARED");
  return std::filesystem::path(shared == nullptr ? "../shared" : shared) / "models" /
         (name + ".obj");
}

PolygonMesh Load(const std::string& name) {
  if (IsSample(name)) return Checked(MakeSampleMesh(name));
  std::ifstream file(ModelPath(name), std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(file), {});
  return Checked(ReadMesh(MeshFormat::kObj, bytes));
}

}  // namespace

bool HasModel(const std::string& name) {
  return IsSample(name) || std::filesystem::exists(ModelPath(name));
}

const Scenario& ModelScenario(const std::string& name) {
  static auto* scenario = new std::optional<Scenario>;
  if (!scenario->has_value() || (*scenario)->name != name) {
    scenario->reset();
    *scenario =
        MakeScenario(name, std::make_shared<const PolygonMesh>(Load(name)), {5, 5, 5}, {2, 2, 2});
  }
  return **scenario;
}

}  // namespace latticed::bench
