// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/gpu/gpu.h"

namespace latticed::bench {

absl::StatusOr<Gpu*> TheGpu() { return absl::UnimplementedError("built without CUDA"); }

}  // namespace latticed::bench
