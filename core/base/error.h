// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Errors that a client sees. Every one is an absl::Status whose code and message stand alone, with
// a machine-readable reason and details attached as a payload; server/wire/grpc_status.cc turns them
// into google.rpc details. Messages say what was got, what is allowed, and what to do.
#ifndef LATTICED_CORE_BASE_ERROR_H_
#define LATTICED_CORE_BASE_ERROR_H_

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/time/time.h"

namespace latticed::error {

// Details of a status. An empty member means that it does not apply.
struct Details {
  std::string reason;                           // UPPER_SNAKE_CASE, of latticed.v1.ErrorReason
  std::string field;                            // path of the offending field
  std::map<std::string, std::string> metadata;  // ids and numbers named in the message
  uint64_t asked_bytes = 0;                     // RESOURCE_EXHAUSTED
  uint64_t free_bytes = 0;
  uint32_t retry_after_ms = 0;  // UNAVAILABLE, ABORTED
};

[[nodiscard]] absl::Status WithDetails(absl::Status status, const Details& details);
// Details of a status made here. Any other status has only a reason, which follows from its code.
[[nodiscard]] Details DetailsOf(const absl::Status& status);

// INVALID_ARGUMENT. `field` is a path such as "lattice.degree.u"; the message starts with it.
[[nodiscard]] absl::Status InvalidField(std::string_view field, std::string_view problem,
                                        std::string_view reason = "INVALID_FIELD");
[[nodiscard]] absl::Status OutOfRange(std::string_view field, double got, double lowest,
                                      double highest);
// OutOfRange where `got` is not in lowest … highest.
[[nodiscard]] absl::Status CheckRange(std::string_view field, double got, double lowest,
                                      double highest);
[[nodiscard]] absl::Status NotFinite(std::string_view field);
// INVALID_ARGUMENT, reason MALFORMED_FILE; `where` is a line or byte offset such as "line 12".
[[nodiscard]] absl::Status MalformedFile(std::string_view format, std::string_view where,
                                         std::string_view problem);
// NOT_FOUND; `kind` is "mesh", "scene", "upload", "watch".
[[nodiscard]] absl::Status NotFound(std::string_view kind, std::string_view id);
// NOT_FOUND, reason NOTHING_HIT: the ray of a pick meets no point of the surface.
[[nodiscard]] absl::Status NothingHit();
// RESOURCE_EXHAUSTED with asked and free bytes.
[[nodiscard]] absl::Status OutOfMemory(std::string_view what, uint64_t asked_bytes,
                                       uint64_t free_bytes);
// The same for one device, whose number is in metadata[kDeviceKey].
inline constexpr char kDeviceKey[] = "device";
[[nodiscard]] absl::Status OutOfDeviceMemory(std::string_view what, int device,
                                             uint64_t asked_bytes, uint64_t free_bytes);
// The same for a caller's share of the memory: metadata has kShareKey.
inline constexpr char kShareKey[] = "share";
[[nodiscard]] absl::Status OutOfShare(std::string_view what, uint64_t asked_bytes,
                                      uint64_t free_bytes);
// RESOURCE_EXHAUSTED for a std::bad_alloc or std::length_error: how much was asked is not known.
[[nodiscard]] absl::Status AllocationFailed(std::string_view what);
// RESOURCE_EXHAUSTED, reason LIMIT_EXCEEDED: a count of ServerInfo.limits is reached.
[[nodiscard]] absl::Status LimitExceeded(std::string_view what, uint64_t limit);
// RESOURCE_EXHAUSTED, reason LIMIT_EXCEEDED: the caller is too fast and should wait.
[[nodiscard]] absl::Status Throttled(std::string_view problem, absl::Duration wait);
// RESOURCE_EXHAUSTED, reason QUOTA_EXCEEDED: a tenant may have `quota` of `what`, has `used`, and asks for more.
// `wait` is zero where waiting does not help.
inline constexpr char kQuotaExceededReason[] = "QUOTA_EXCEEDED";
[[nodiscard]] absl::Status QuotaExceeded(std::string_view what, uint64_t quota, uint64_t used,
                                         uint64_t asked, absl::Duration wait);
[[nodiscard]] absl::Status FailedPrecondition(std::string_view reason, std::string_view message);
// FAILED_PRECONDITION, reason OPEN_SURFACE: the surface encloses no volume. Metadata has both counts.
[[nodiscard]] absl::Status OpenSurface(uint64_t border_edges, uint64_t torn_edges);
// FAILED_PRECONDITION, reason VERTEX_WEIGHTS: the scene has vertex weights, and `what` does not take them.
[[nodiscard]] absl::Status NotWithWeights(std::string_view what);
// INVALID_ARGUMENT, reason UNSUPPORTED: patches as a stream were asked for where there are none.
[[nodiscard]] absl::Status NoPatches(std::string_view field);
// FAILED_PRECONDITION, reason TURNED_LATTICES: lattices of the scene are turned against each other, and `what` does not
// take them.
[[nodiscard]] absl::Status NotWithTurned(std::string_view what);
// kFailedPrecondition: an edit of a lattice that was removed.
[[nodiscard]] absl::Status LatticeRemoved();
[[nodiscard]] absl::Status Aborted(std::string_view reason, std::string_view message);
[[nodiscard]] absl::Status AlreadyExists(std::string_view kind, std::string_view id);
[[nodiscard]] absl::Status Unsupported(std::string_view field, std::string_view what);
[[nodiscard]] absl::Status Unimplemented(std::string_view what);
[[nodiscard]] absl::Status Unauthenticated(std::string_view problem);
[[nodiscard]] absl::Status PermissionDenied(std::string_view problem, std::string_view role_needed);
[[nodiscard]] absl::Status Unavailable(std::string_view reason, std::string_view message,
                                       uint32_t retry_after_ms);

}  // namespace latticed::error

#endif  // LATTICED_CORE_BASE_ERROR_H_
