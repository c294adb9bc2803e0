// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/support/backends.h"

#include <cstdlib>

#include "absl/strings/str_split.h"
#include "core/cpu/cpu_backend.h"

namespace latticed::testing {

std::vector<std::string> KnownBackends() { return {"cpu"}; }

std::unique_ptr<Backend> MakeBackendByName(std::string_view name, int threads) {
  if (name == "cpu") return MakeCpuBackend({.threads = threads});
  return nullptr;
}

std::vector<std::string> RequiredBackends() {
  const char* names = std::getenv("LATTICED_REQUIRE_BACKENDS");
  if (names == nullptr) return {"cpu"};
  return absl::StrSplit(names, ',', absl::SkipEmpty());
}

}  // namespace latticed::testing
