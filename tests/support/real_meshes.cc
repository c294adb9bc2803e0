// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/support/real_meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <utility>

#include "core/mesh/mesh_io.h"

namespace latticed::testing {

std::vector<RealMesh> RealMeshes() {
  const char* shared = std::getenv("LATTICED_SHARED");
  const std::filesystem::path folder =
      std::filesystem::path(shared == nullptr ? "." : shared) / "models";
  std::vector<RealMesh> meshes;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(folder, ignored)) {
    const auto format = MeshFormatFromFileName(entry.path().string());
    if (!format.ok() || *format == MeshFormat::kDraco) continue;
    std::ifstream file(entry.path(), std::ios::binary);
    const std::string bytes(std::istreambuf_iterator<char>(file), {});
    auto mesh = ReadMesh(*format, bytes);
    if (!mesh.ok()) {
      ADD_FAILURE() << entry.path() << ": " << mesh.status();
      continue;
    }
    meshes.push_back({entry.path().stem().string(), *std::move(mesh)});
  }
  std::sort(meshes.begin(), meshes.end(),
            [](const RealMesh& a, const RealMesh& b) { return a.name < b.name; });
  return meshes;
}

}  // namespace latticed::testing
