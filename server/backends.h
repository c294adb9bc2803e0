// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The backends that this server evaluates on, by Options::backend.
#ifndef LATTICED_SERVER_BACKENDS_H_
#define LATTICED_SERVER_BACKENDS_H_

#include <memory>
#include <vector>

#include "absl/status/statusor.h"
#include "core/backend.h"
#include "server/base/options.h"

namespace latticed {

// The first one serves: with auto CUDA where there is a device, and the CPU elsewhere. Where CUDA was
// asked for by name: MakeCudaBackend's errors.
[[nodiscard]] absl::StatusOr<std::vector<std::unique_ptr<Backend>>> MakeBackends(
    const Options& options);

}  // namespace latticed

#endif  // LATTICED_SERVER_BACKENDS_H_
