// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/wire/stored_scene.h"

#include <utility>

#include "core/base/status_macros.h"
#include "server/base/auth/tenant.h"
#include "server/base/random_id.h"
#include "server/store/records/header_codec.h"
#include "server/store/records/scene_log.pb.h"
#include "server/wire/scene_converters.h"

namespace latticed {
namespace {

struct Stored {
  SceneHeader header;
  v1::CreateSceneRequest request;
};

absl::StatusOr<Stored> Decode(std::string_view bytes) {
  Stored stored;
  LATTICED_ASSIGN_OR_RETURN(stored.header, DecodeHeader(bytes));
  if (!stored.request.ParseFromString(stored.header.request)) {
    return absl::DataLossError("the request that made the scene cannot be read");
  }
  return stored;
}

}  // namespace

std::string StoredHeaderOf(const v1::CreateSceneRequest& request, const SceneConfig& config) {
  return EncodeHeader({.request = request.SerializeAsString(),
                       .owner = config.owner,
                       .lattices = config.lattices,
                       .create_time = config.create_time,
                       .idle_ttl = config.idle_ttl,
                       .listing = ToProto(config).SerializeAsString(),
                       .token_key = config.token_key,
                       .tenant = std::string(TenantOf(config.id)),
                       .strength = config.strength});
}

absl::StatusOr<StoredScene> StoredSceneOf(std::string_view header) {
  LATTICED_ASSIGN_OR_RETURN(const auto stored, Decode(header));
  return StoredScene{TenantKey(stored.header.tenant, stored.request.mesh()),
                     stored.header.idle_ttl};
}

absl::StatusOr<v1::Scene> ListedScene(std::string_view header) {
  store::SceneHeader stored;  // not by DecodeHeader, which makes its lattice
  v1::Scene scene;
  if (!stored.ParseFromArray(header.data(), static_cast<int>(header.size())) ||
      stored.listing().empty() || !scene.ParseFromString(stored.listing())) {
    return absl::DataLossError("the header has nothing that lists show");
  }
  scene.set_asleep(true);
  return scene;
}

absl::StatusOr<SceneConfig> SceneConfigFromStored(std::string_view header, const StoredMesh& mesh) {
  LATTICED_ASSIGN_OR_RETURN(auto stored, Decode(header));
  LATTICED_ASSIGN_OR_RETURN(
      auto config,
      SceneConfigFromProto(stored.request, mesh, stored.header.owner, stored.header.idle_ttl));
  config.create_time = stored.header.create_time;
  config.token_key = stored.header.token_key;
  return config;
}

absl::StatusOr<std::string> HeaderForCopy(std::string_view header) {
  store::SceneHeader stored;
  if (!stored.ParseFromArray(header.data(), static_cast<int>(header.size()))) {
    return absl::DataLossError("the header of the scene cannot be read");
  }
  stored.clear_token_key();
  stored.clear_tenant();
  return stored.SerializeAsString();
}

absl::StatusOr<SceneConfig> SceneConfigFromCopy(std::string_view header, const StoredMesh& mesh,
                                                const std::optional<std::string>& owner) {
  LATTICED_ASSIGN_OR_RETURN(auto stored, Decode(header));
  LATTICED_RETURN_IF_ERROR(CheckCreateScene(stored.request));
  if (stored.request.mesh() != IdOf(mesh.id)) return absl::DataLossError("it is of another mesh");
  if (stored.header.idle_ttl <= absl::ZeroDuration()) {
    return absl::DataLossError("it expires before it is made");
  }
  LATTICED_ASSIGN_OR_RETURN(
      auto config, SceneConfigFromProto(stored.request, mesh, owner.value_or(stored.header.owner),
                                        stored.header.idle_ttl));
  config.lattices = std::move(stored.header.lattices);
  config.create_time = stored.header.create_time;
  config.token_key = NewRandomId();  // a token of the first scene is none of this one
  config.stored_header = StoredHeaderOf(stored.request, config);
  return config;
}

}  // namespace latticed
