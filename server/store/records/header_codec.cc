// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/store/records/header_codec.h"

#include <utility>

#include "core/base/status_macros.h"
#include "core/ffd/edit/lattice_edit.h"
#include "server/store/records/lattice_codec.h"

namespace latticed {

std::string EncodeHeader(const SceneHeader& header) {
  store::SceneHeader stored;
  stored.set_request(header.request);
  stored.set_owner(header.owner);
  for (const Lattice& lattice : header.lattices) ToStored(lattice, *stored.add_lattices());
  stored.set_create_time(absl::ToUnixNanos(header.create_time));
  stored.set_idle_ttl(absl::ToInt64Nanoseconds(header.idle_ttl));
  stored.set_listing(header.listing);
  stored.set_token_key(header.token_key);
  stored.set_tenant(header.tenant);
  stored.set_strength(header.strength);
  return stored.SerializeAsString();
}

absl::StatusOr<SceneHeader> DecodeHeader(std::string_view bytes) {
  store::SceneHeader stored;
  if (!stored.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
    return NotARecord("no header");
  }
  SceneHeader header{.request = stored.request(),
                     .owner = stored.owner(),
                     .create_time = absl::FromUnixNanos(stored.create_time()),
                     .idle_ttl = absl::Nanoseconds(stored.idle_ttl()),
                     .listing = stored.listing(),
                     .token_key = stored.token_key(),
                     .tenant = stored.tenant(),
                     .strength = stored.has_strength() ? stored.strength() : 1};
  for (const store::Lattice& item : stored.lattices()) {
    LATTICED_ASSIGN_OR_RETURN(auto lattice, LatticeFromStored(item));
    if (!Validate(lattice).ok()) return NotARecord("a lattice of a header");
    header.lattices.push_back(std::move(lattice));
  }
  if (header.lattices.empty()) return NotARecord("a header without a lattice");
  if (!CheckStrength(header.strength, "").ok()) return NotARecord("the strength of a header");
  return header;
}

}  // namespace latticed
