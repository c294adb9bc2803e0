// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What a scene was made from, as bytes (scene_log.proto).
//
// Errors   kDataLoss for bytes that no encoder made
// Threads  pure functions
#ifndef LATTICED_SERVER_STORE_RECORDS_HEADER_CODEC_H_
#define LATTICED_SERVER_STORE_RECORDS_HEADER_CODEC_H_

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "core/ffd/lattice.h"

namespace latticed {

struct SceneHeader {
  std::string request;  // latticed.v1.CreateSceneRequest
  std::string owner;
  std::vector<Lattice> lattices;  // at revision 0; valid, and at least one
  absl::Time create_time;
  absl::Duration idle_ttl;
  std::string listing;    // latticed.v1.Scene
  std::string token_key;  // of resume tokens; empty in headers of older servers
  std::string tenant;
  double strength = 1;  // at revision 0
};

[[nodiscard]] std::string EncodeHeader(const SceneHeader& header);
[[nodiscard]] absl::StatusOr<SceneHeader> DecodeHeader(std::string_view bytes);

}  // namespace latticed

#endif  // LATTICED_SERVER_STORE_RECORDS_HEADER_CODEC_H_
