// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Evaluated vertices -> the snapshot of their revision.
//
// Errors   those of `encode`
// Threads  holds no lock
#ifndef LATTICED_SERVER_ENGINE_RENDER_ENCODE_SNAPSHOT_H_
#define LATTICED_SERVER_ENGINE_RENDER_ENCODE_SNAPSHOT_H_

#include <memory>
#include <span>
#include <vector>

#include "absl/functional/function_ref.h"
#include "absl/status/statusor.h"
#include "core/backend.h"
#include "server/engine/render/snapshot.h"
#include "server/engine/scene/scene_state.h"

namespace latticed {

// DeformView::Encode of one batch of chunks. It may be tried again after an error; each attempt begins with known().
using KnownDigests = absl::FunctionRef<std::span<VertexDigest>()>;
using EncodeBatch = absl::FunctionRef<absl::StatusOr<std::vector<SharedBytes>>(
    std::span<const uint32_t> chunks, KnownDigests known, TakeEarly early)>;

// Encodes `chunks` in batches and takes the others from `before`, which may be null if `chunks` are
// all. Then chunks get these `revisions`, unless that is empty. A chunk whose vertices are those of its
// old bytes is not encoded and keeps its revision, as does one whose new bytes equal the old ones.
// Another pattern of a patch is always a change. `patterns`: those of all chunks, DeformView::Patterns.
[[nodiscard]] absl::StatusOr<std::shared_ptr<Snapshot>> EncodeSnapshot(
    const ViewKey& key, const SceneState& state, std::span<const uint32_t> chunks,
    std::span<const uint64_t> revisions, const ViewTraits& traits, const Snapshot* before,
    EncodeBatch encode, PatternCodes patterns);

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_RENDER_ENCODE_SNAPSHOT_H_
