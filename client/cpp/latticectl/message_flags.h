// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Options that fill in a message of the protocol. An option that is not given leaves its field as it
// is; an empty field of a view takes the scene's default view.
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_MESSAGE_FLAGS_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_MESSAGE_FLAGS_H_

#include <string>

#include "latticed/v1/mesh.pb.h"
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

// --up-axis z, --meters-per-unit 0.001: what the numbers of a mesh file mean.
void AddUnitsFlags(CLI::App& command, v1::MeshUnits& units);
// "x", "y", "z"; empty for an unknown one.
[[nodiscard]] std::string UpAxisName(v1::UpAxis axis);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_MESSAGE_FLAGS_H_
