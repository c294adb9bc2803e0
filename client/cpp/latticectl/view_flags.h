// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Options that say how a surface is seen; what is not given is left to the scene's default view.
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_VIEW_FLAGS_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_VIEW_FLAGS_H_

#include <cstdint>
#include <string>

#include "latticed/v1/scene.pb.h"
#include "latticed/v1/view.pb.h"

namespace CLI {
class App;
}

namespace latticed::client {

struct ViewFlags {
  int segments = 0;
  std::string normals;   // facet, smooth, none
  std::string encoding;  // raw, draco, draco-mesh, quantised
  int position_bits = 0;
  int normal_bits = 0;
  // While edits come, for who watches.
  uint64_t max_points = 0;
  uint64_t max_bytes_per_second = 0;
  int drag_position_bits = 0;
  int drag_normal_bits = 0;
};

void AddViewFlags(CLI::App& command, ViewFlags& flags);
// Those that matter while edits come.
void AddDragFlags(CLI::App& command, ViewFlags& flags);
[[nodiscard]] v1::ViewOptions ToProto(const ViewFlags& flags);

// --pipeline: fused, gemm, gemm12, control-net.
void AddPipelineFlag(CLI::App& command, std::string& pipeline);
[[nodiscard]] v1::Pipeline PipelineToProto(const std::string& pipeline);

// "draco", "raw", …: the name that --encoding takes.
[[nodiscard]] std::string EncodingName(v1::Encoding encoding);
[[nodiscard]] std::string NormalModeName(v1::NormalMode normals);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_VIEW_FLAGS_H_
