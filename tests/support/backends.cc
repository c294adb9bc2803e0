// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/support/backends.h"

#include <algorithm>
#include <cstdlib>

#include "absl/strings/str_split.h"
#include "core/base/error.h"
#include "core/cpu/cpu_backend.h"
#include "cuda/cuda_backend.h"

namespace latticed::testing {

std::vector<std::string> KnownBackends() { return {"cpu", "cuda"}; }

absl::StatusOr<std::unique_ptr<Backend>> MakeBackendByName(std::string_view name, int threads) {
  if (name == "cpu") return MakeCpuBackend({.threads = threads});
  if (name == "cuda") return MakeCudaBackend({.threads = threads});
  return error::NotFound("backend", name);
}

std::vector<std::string> RequiredBackends() {
  const char* names = std::getenv("LATTICED_REQUIRE_BACKENDS");
  if (names == nullptr) return {"cpu"};
  return absl::StrSplit(names, ',', absl::SkipEmpty());
}

bool IsRequired(std::string_view name) {
  const std::vector<std::string> required = RequiredBackends();
  return std::find(required.begin(), required.end(), name) != required.end();
}

}  // namespace latticed::testing
