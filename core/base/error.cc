// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/base/error.h"

#include <nlohmann/json.hpp>

#include "absl/strings/cord.h"
#include "fmt/format.h"

namespace latticed::error {
namespace {

// The payload of a status with details: a CBOR array of the members of Details, in their order. The ids
// of clients may hold any bytes, which CBOR carries as they are.
constexpr char kPayloadUrl[] = "latticed/error-details";

absl::Status Make(absl::StatusCode code, std::string_view message, const Details& details) {
  return WithDetails(absl::Status(code, std::string(message)), details);
}

std::string_view ReasonOfCode(absl::StatusCode code) {
  switch (code) {
    case absl::StatusCode::kInvalidArgument:
      return "INVALID_FIELD";
    case absl::StatusCode::kNotFound:
      return "NOT_FOUND";
    case absl::StatusCode::kAlreadyExists:
      return "ALREADY_EXISTS";
    case absl::StatusCode::kResourceExhausted:
      return "OUT_OF_MEMORY";
    case absl::StatusCode::kUnimplemented:
      return "UNSUPPORTED";
    case absl::StatusCode::kUnauthenticated:
      return "UNAUTHENTICATED";
    case absl::StatusCode::kPermissionDenied:
      return "PERMISSION_DENIED";
    case absl::StatusCode::kUnavailable:
      return "UNAVAILABLE";
    case absl::StatusCode::kCancelled:
      return "CANCELLED";
    case absl::StatusCode::kDeadlineExceeded:
      return "DEADLINE_EXCEEDED";
    default:
      return "INTERNAL";
  }
}

}  // namespace

absl::Status WithDetails(absl::Status status, const Details& details) {
  std::string payload;
  nlohmann::json::to_cbor(
      nlohmann::json::array({details.reason, details.field, details.metadata, details.asked_bytes,
                             details.free_bytes, details.retry_after_ms}),
      payload);
  status.SetPayload(kPayloadUrl, absl::Cord(payload));
  return status;
}

Details DetailsOf(const absl::Status& status) {
  const auto payload = status.GetPayload(kPayloadUrl);
  if (!payload.has_value()) return {.reason = std::string(ReasonOfCode(status.code()))};
  const auto members = nlohmann::json::from_cbor(std::string(*payload));
  return {.reason = members[0],
          .field = members[1],
          .metadata = members[2],
          .asked_bytes = members[3],
          .free_bytes = members[4],
          .retry_after_ms = members[5]};
}

absl::Status InvalidField(std::string_view field, std::string_view problem,
                          std::string_view reason) {
  return Make(absl::StatusCode::kInvalidArgument, fmt::format("{}: {}", field, problem),
              {.reason = std::string(reason), .field = std::string(field)});
}

absl::Status OutOfRange(std::string_view field, double got, double lowest, double highest) {
  return InvalidField(field, fmt::format("got {}, allowed is {} to {}", got, lowest, highest),
                      "OUT_OF_RANGE");
}

absl::Status CheckRange(std::string_view field, double got, double lowest, double highest) {
  if (got >= lowest && got <= highest) return absl::OkStatus();
  return OutOfRange(field, got, lowest, highest);
}

absl::Status NotFinite(std::string_view field) {
  return InvalidField(field, "holds NaN or infinity; all numbers must be finite", "NOT_FINITE");
}

absl::Status MalformedFile(std::string_view format, std::string_view where,
                           std::string_view problem) {
  return Make(absl::StatusCode::kInvalidArgument,
              fmt::format("data: not a valid {} file, {}: {}", format, where, problem),
              {.reason = "MALFORMED_FILE",
               .field = "data",
               .metadata = {{"format", std::string(format)}, {"where", std::string(where)}}});
}

absl::Status NotFound(std::string_view kind, std::string_view id) {
  return Make(
      absl::StatusCode::kNotFound, fmt::format("no {} with id '{}'", kind, id),
      {.reason = "NOT_FOUND", .metadata = {{"kind", std::string(kind)}, {"id", std::string(id)}}});
}

absl::Status NothingHit() {
  return Make(absl::StatusCode::kNotFound, "ray: meets no point of the surface",
              {.reason = "NOTHING_HIT"});
}

absl::Status OutOfMemory(std::string_view what, uint64_t asked_bytes, uint64_t free_bytes) {
  return Make(absl::StatusCode::kResourceExhausted,
              fmt::format("{} needs {} bytes, {} are free", what, asked_bytes, free_bytes),
              {.reason = "OUT_OF_MEMORY", .asked_bytes = asked_bytes, .free_bytes = free_bytes});
}

absl::Status OutOfShare(std::string_view what, uint64_t asked_bytes, uint64_t free_bytes) {
  return Make(absl::StatusCode::kResourceExhausted,
              fmt::format("{} needs {} bytes, {} are free of what one caller may use", what,
                          asked_bytes, free_bytes),
              {.reason = "OUT_OF_MEMORY",
               .metadata = {{kShareKey, "caller"}},
               .asked_bytes = asked_bytes,
               .free_bytes = free_bytes});
}

absl::Status OutOfDeviceMemory(std::string_view what, int device, uint64_t asked_bytes,
                               uint64_t free_bytes) {
  return Make(absl::StatusCode::kResourceExhausted,
              fmt::format("{} on device {} needs {} bytes, {} are free", what, device, asked_bytes,
                          free_bytes),
              {.reason = "OUT_OF_MEMORY",
               .metadata = {{kDeviceKey, fmt::to_string(device)}},
               .asked_bytes = asked_bytes,
               .free_bytes = free_bytes});
}

absl::Status AllocationFailed(std::string_view what) {
  return Make(absl::StatusCode::kResourceExhausted,
              fmt::format("{} needs more memory than the machine has left", what),
              {.reason = "OUT_OF_MEMORY"});
}

absl::Status LimitExceeded(std::string_view what, uint64_t limit) {
  return Make(absl::StatusCode::kResourceExhausted,
              fmt::format("no more {}: at most {} at a time; close one and try again", what, limit),
              {.reason = "LIMIT_EXCEEDED", .metadata = {{"limit", fmt::format("{}", limit)}}});
}

absl::Status Throttled(std::string_view problem, absl::Duration wait) {
  const absl::Duration rounded = absl::Ceil(wait, absl::Milliseconds(1));
  return Make(absl::StatusCode::kResourceExhausted,
              fmt::format("{}; try again in {}", problem, absl::FormatDuration(rounded)),
              {.reason = "LIMIT_EXCEEDED",
               .retry_after_ms = static_cast<uint32_t>(absl::ToInt64Milliseconds(rounded))});
}

absl::Status QuotaExceeded(std::string_view what, uint64_t quota, uint64_t used, uint64_t asked,
                           absl::Duration wait) {
  return Make(absl::StatusCode::kResourceExhausted,
              fmt::format("the tenant's quota of {} is {}: {} are used, {} more were asked for",
                          what, quota, used, asked),
              {.reason = kQuotaExceededReason,
               .metadata = {{"what", std::string(what)},
                            {"allowed", fmt::to_string(quota)},
                            {"used", fmt::to_string(used)},
                            {"asked", fmt::to_string(asked)}},
               .retry_after_ms = static_cast<uint32_t>(
                   absl::ToInt64Milliseconds(absl::Ceil(wait, absl::Milliseconds(1))))});
}

absl::Status FailedPrecondition(std::string_view reason, std::string_view message) {
  return Make(absl::StatusCode::kFailedPrecondition, message, {.reason = std::string(reason)});
}

absl::Status OpenSurface(uint64_t border_edges, uint64_t torn_edges) {
  return WithDetails(absl::FailedPreconditionError(
                         fmt::format("the surface encloses no volume: {} edges of the mesh are "
                                     "borders, {} edges of patches are torn at faces of the "
                                     "lattice's frame",
                                     border_edges, torn_edges)),
                     {.reason = "OPEN_SURFACE",
                      .metadata = {{"border_edges", fmt::to_string(border_edges)},
                                   {"torn_edges", fmt::to_string(torn_edges)}}});
}

absl::Status NotWithWeights(std::string_view what) {
  return FailedPrecondition(
      "VERTEX_WEIGHTS",
      fmt::format("the scene has vertex weights, and {} does not take them", what));
}

absl::Status NoPatches(std::string_view field) {
  return InvalidField(field,
                      "no patches here: the scene's lattices are turned against each other, or its "
                      "pipeline has none on these devices",
                      "UNSUPPORTED");
}

absl::Status NotWithTurned(std::string_view what) {
  return FailedPrecondition(
      "TURNED_LATTICES",
      fmt::format("lattices of the scene are turned against each other, and {} does not take them",
                  what));
}

absl::Status LatticeRemoved() {
  return FailedPrecondition("LATTICE_REMOVED",
                            "lattice: it was removed; undo that, or put a lattice in its place");
}

absl::Status Aborted(std::string_view reason, std::string_view message) {
  return Make(absl::StatusCode::kAborted, message, {.reason = std::string(reason)});
}

absl::Status AlreadyExists(std::string_view kind, std::string_view id) {
  return Make(absl::StatusCode::kAlreadyExists,
              fmt::format("another {} with id '{}' exists", kind, id),
              {.reason = "ALREADY_EXISTS",
               .metadata = {{"kind", std::string(kind)}, {"id", std::string(id)}}});
}

absl::Status Unsupported(std::string_view field, std::string_view what) {
  return InvalidField(field, fmt::format("this server does not know {}", what), "UNSUPPORTED");
}

absl::Status Unimplemented(std::string_view what) {
  return Make(absl::StatusCode::kUnimplemented, fmt::format("{} is not implemented", what),
              {.reason = "UNSUPPORTED"});
}

absl::Status Unauthenticated(std::string_view problem) {
  return Make(absl::StatusCode::kUnauthenticated, problem, {.reason = "UNAUTHENTICATED"});
}

absl::Status PermissionDenied(std::string_view problem, std::string_view role_needed) {
  return Make(absl::StatusCode::kPermissionDenied, problem,
              {.reason = "PERMISSION_DENIED", .metadata = {{"role", std::string(role_needed)}}});
}

absl::Status Unavailable(std::string_view reason, std::string_view message,
                         uint32_t retry_after_ms) {
  return Make(absl::StatusCode::kUnavailable, message,
              {.reason = std::string(reason), .retry_after_ms = retry_after_ms});
}

}  // namespace latticed::error
