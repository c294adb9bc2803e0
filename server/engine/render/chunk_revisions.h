// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// When edits last reached each chunk of a view. A view that is made anew, also by another server, knows by them which
// chunks a client has already.
//
// The bytes and patterns of a chunk are a function of control points, quantisation box and view, whatever edits led there.
// An edit may change them if it moves
//
//   positions                     one of the chunk's patches
//   positions with a tolerance    a patch that shares an edge with one of these: both choose the level of the edge.
//                                 The points of the whole view count too: see FirstSnapshot
//   bounds of edges               a patch that has one of the chunk's edges
//
// Threads  pure functions
#ifndef LATTICED_SERVER_ENGINE_RENDER_CHUNK_REVISIONS_H_
#define LATTICED_SERVER_ENGINE_RENDER_CHUNK_REVISIONS_H_

#include <cstdint>
#include <vector>

#include "core/backend.h"
#include "core/ffd/plan/deform_plan.h"
#include "server/engine/scene/point_revisions.h"

namespace latticed {

// By chunk of the plan: the revision of the last edit that may have changed it in views of `spec`.
[[nodiscard]] std::vector<uint64_t> ChunkRevisions(const DeformPlan& plan,
                                                   const PointRevisions& points,
                                                   const ViewSpec& spec);

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_RENDER_CHUNK_REVISIONS_H_
