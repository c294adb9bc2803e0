// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/support/backends.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "absl/strings/str_split.h"
#include "core/base/error.h"
#include "core/cpu/cpu_backend.h"
#include "core/view/device_group.h"
#include "cuda/cuda_backend.h"

namespace latticed::testing {

namespace {

constexpr int kCpuParts = 3;

std::unique_ptr<Backend> SpannedCpu(int threads) {
  std::vector<std::unique_ptr<Backend>> parts;
  for (int i = 0; i < kCpuParts; ++i) parts.push_back(MakeCpuBackend({.threads = threads}));
  return MakeDeviceGroup(std::move(parts), 1);
}

absl::StatusOr<std::unique_ptr<Backend>> SpannedCuda(int threads) {
  auto two = MakeCudaBackend({.devices = {0, 1}, .span_patches = 1, .threads = threads});
  if (two.ok()) return two;
  return MakeCudaBackend({.devices = {0, 0}, .span_patches = 1, .threads = threads});
}

}  // namespace

std::vector<std::string> KnownBackends() { return {"cpu", "cuda"}; }

std::string SpannedName(std::string_view name) { return std::string(name) + std::string(kSpanned); }

std::string UnspannedName(std::string_view name) {
  if (name.ends_with(kSpanned)) name.remove_suffix(kSpanned.size());
  return std::string(name);
}

absl::StatusOr<std::unique_ptr<Backend>> MakeBackendByName(std::string_view name, int threads) {
  if (name == "cpu") return MakeCpuBackend({.threads = threads});
  if (name == "cuda") return MakeCudaBackend({.threads = threads});
  if (name == SpannedName("cpu")) return SpannedCpu(threads);
  if (name == SpannedName("cuda")) return SpannedCuda(threads);
  return error::NotFound("backend", name);
}

std::vector<std::string> RequiredBackends() {
  const char* names = std::getenv("LATTICED_REQUIRE_BACKENDS");
  if (names == nullptr) return {"cpu"};
  return absl::StrSplit(names, ',', absl::SkipEmpty());
}

bool IsRequired(std::string_view name) {
  const std::vector<std::string> required = RequiredBackends();
  return std::find(required.begin(), required.end(), UnspannedName(name)) != required.end();
}

}  // namespace latticed::testing
