// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Backends by name, for suites that run on each of them. backends.cc lists the backends.
// LATTICED_REQUIRE_BACKENDS=cpu,cuda turns a missing backend into a failure.
#ifndef LATTICED_TESTS_SUPPORT_BACKENDS_H_
#define LATTICED_TESTS_SUPPORT_BACKENDS_H_

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/backend.h"

namespace latticed::testing {

// The names of all backends, whether this machine has them or not.
[[nodiscard]] std::vector<std::string> KnownBackends();
// The name of a backend that splits every plan: "cpu-spanned" over three CPU backends, "cuda-spanned"
// over the first two devices, or over the first one twice if there is no second.
inline constexpr std::string_view kSpanned = "-spanned";
[[nodiscard]] std::string SpannedName(std::string_view name);
[[nodiscard]] std::string UnspannedName(std::string_view name);
// An error that says why if this machine or build has no backend of that name. threads 0: all.
[[nodiscard]] absl::StatusOr<std::unique_ptr<Backend>> MakeBackendByName(std::string_view name,
                                                                         int threads = 0);
// The backend "cpu" or "cuda", with every plan split over so many devices. "cuda" takes those that there are in turn.
[[nodiscard]] absl::StatusOr<std::unique_ptr<Backend>> MakeSpannedBackend(std::string_view name,
                                                                          int devices,
                                                                          int threads = 0);
// Names in LATTICED_REQUIRE_BACKENDS; "cpu" when it is not set.
[[nodiscard]] std::vector<std::string> RequiredBackends();
[[nodiscard]] bool IsRequired(std::string_view name);

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SUPPORT_BACKENDS_H_
