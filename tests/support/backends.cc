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

constexpr int kCpuParts = 3, kCudaParts = 2;

std::unique_ptr<Backend> SpannedCpu(int devices, int threads) {
  std::vector<std::unique_ptr<Backend>> parts;
  for (int i = 0; i < devices; ++i) parts.push_back(MakeCpuBackend({.threads = threads}));
  return MakeDeviceGroup(std::move(parts), 1);
}

absl::StatusOr<std::unique_ptr<Backend>> SpannedCuda(int devices, int threads) {
  absl::StatusOr<std::unique_ptr<Backend>> backend;
  for (int present = devices; present > 0; --present) {
    std::vector<int> numbers;
    for (int i = 0; i < devices; ++i) numbers.push_back(i % present);
    backend = MakeCudaBackend({.devices = numbers, .span_patches = 1, .threads = threads});
    if (backend.ok()) break;
  }
  return backend;
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
  if (name == SpannedName("cpu")) return SpannedCpu(kCpuParts, threads);
  if (name == SpannedName("cuda")) return SpannedCuda(kCudaParts, threads);
  return error::NotFound("backend", name);
}

absl::StatusOr<std::unique_ptr<Backend>> MakeSpannedBackend(std::string_view name, int devices,
                                                            int threads) {
  if (name == "cpu") return SpannedCpu(devices, threads);
  if (name == "cuda") return SpannedCuda(devices, threads);
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
