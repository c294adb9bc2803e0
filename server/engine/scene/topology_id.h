// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Names the layout of a view's points. The same mesh, knots, frame and segments give the same name,
// in every scene and every run of the server: clients may cache what GetTopology says under it.
//
// Threads  pure function
#ifndef LATTICED_SERVER_ENGINE_SCENE_TOPOLOGY_ID_H_
#define LATTICED_SERVER_ENGINE_SCENE_TOPOLOGY_ID_H_

#include <string>
#include <string_view>

#include "core/ffd/lattice.h"

namespace latticed {

// 32 hex digits of a hash, a dash, and the segments.
[[nodiscard]] std::string TopologyId(std::string_view mesh_id, const LatticeStructure& structure,
                                     int segments);

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_SCENE_TOPOLOGY_ID_H_
