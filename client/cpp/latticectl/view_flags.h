// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Options that say how a surface is seen. An option that is not given stays as it is in the
// message; an empty field takes the scene's default view.
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_VIEW_FLAGS_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_VIEW_FLAGS_H_

#include <string>

#include "latticed/v1/scene.pb.h"
#include "latticed/v1/view.pb.h"

namespace CLI {
class App;
}

namespace latticed::client {

// --segments, --normals, --encoding, --position-bits, --normal-bits.
void AddViewFlags(CLI::App& command, v1::ViewOptions& view);
// Options in force while edits come: --max-points, --max-bytes-per-second, --drag-…-bits.
void AddDragFlags(CLI::App& command, v1::ViewOptions& view);

// --pipeline: fused, gemm, gemm12, control-net.
void AddPipelineFlag(CLI::App& command, v1::Pipeline& pipeline);

// "draco", "raw", …: the name that --encoding takes.
[[nodiscard]] std::string EncodingName(v1::Encoding encoding);
[[nodiscard]] std::string NormalModeName(v1::NormalMode normals);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_VIEW_FLAGS_H_
