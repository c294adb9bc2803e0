// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Leaves a function with the error of what it called.
//
//   LATTICED_RETURN_IF_ERROR(Validate(lattice));                 a Status
//   LATTICED_ASSIGN_OR_RETURN(auto plan, MakePlan(mesh, stop));  a StatusOr: its value, moved out
//
// Use   in functions that return absl::Status or absl::StatusOr. The second is several statements:
//       not the body of an `if` without braces.
#ifndef LATTICED_CORE_BASE_STATUS_MACROS_H_
#define LATTICED_CORE_BASE_STATUS_MACROS_H_

#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

#define LATTICED_RETURN_IF_ERROR(...)                                          \
  do {                                                                         \
    if (absl::Status latticed_status = (__VA_ARGS__); !latticed_status.ok()) { \
      return latticed_status;                                                  \
    }                                                                          \
  } while (false)

#define LATTICED_ASSIGN_OR_RETURN(value, ...) \
  LATTICED_ASSIGN_OR_RETURN_AS(LATTICED_CONCATENATE(latticed_answer_, __LINE__), value, __VA_ARGS__)

#define LATTICED_ASSIGN_OR_RETURN_AS(answer, value, ...) \
  auto answer = (__VA_ARGS__);                           \
  if (!answer.ok()) return std::move(answer).status();   \
  value = *std::move(answer)

#define LATTICED_CONCATENATE(a, b) LATTICED_CONCATENATE_TOKENS(a, b)
#define LATTICED_CONCATENATE_TOKENS(a, b) a##b

#endif  // LATTICED_CORE_BASE_STATUS_MACROS_H_
