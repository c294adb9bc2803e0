// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Several devices as one backend. Each plan goes to the device with the most free budget; a large one is shared out
// among all of them.
//
//   shared out   plans of `span_patches` patches or more, or of more bytes than any one device's
//                budget, a view of 10 segments counted in; by pipeline kFused alone, in runs of
//                chunks, with the same bits
//   else         the target of the device itself, without a wrapper
//
// Errors   those of the devices; where one part is refused, no part keeps anything
// Threads  safe
#ifndef LATTICED_CORE_VIEW_DEVICE_GROUP_H_
#define LATTICED_CORE_VIEW_DEVICE_GROUP_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/backend.h"

namespace latticed {

// Two devices halve the time of an evaluation of so many patches, from about 0.7 ms, which a client
// can notice. For smaller scenes it is better to keep the second device for other scenes.
inline constexpr uint64_t kDefaultSpanPatches = 1'000'000;

// Each of `devices` is a backend with one device. There is at least one, and all have the same name. A single device
// is returned as it is.
[[nodiscard]] std::unique_ptr<Backend> MakeDeviceGroup(
    std::vector<std::unique_ptr<Backend>> devices, uint64_t span_patches = kDefaultSpanPatches);

// Shares `chunks` among devices: in equal counts, where every device has memory for an equal share;
// else in proportion to the free memory. All patches cost the same, so equal counts take equal
// times.
// Device i gets the run [result[i], result[i + 1]), which may be empty.
[[nodiscard]] std::vector<size_t> ShareChunks(size_t chunks, uint64_t bytes_per_chunk,
                                              std::span<const uint64_t> free_bytes);

}  // namespace latticed

#endif  // LATTICED_CORE_VIEW_DEVICE_GROUP_H_
