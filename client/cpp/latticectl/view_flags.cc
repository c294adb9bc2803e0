// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/view_flags.h"

#include <CLI/CLI.hpp>
#include <array>
#include <utility>

#include "core/base/limits.h"

namespace latticed::client {
namespace {

template <typename Enum, size_t N>
using Names = std::array<std::pair<const char*, Enum>, N>;

constexpr Names<v1::NormalMode, 3> kNormalModes{{{"facet", v1::NORMAL_MODE_FACET},
                                                 {"smooth", v1::NORMAL_MODE_SMOOTH},
                                                 {"none", v1::NORMAL_MODE_NONE}}};
constexpr Names<v1::Encoding, 4> kEncodings{{{"raw", v1::ENCODING_RAW},
                                             {"draco", v1::ENCODING_DRACO_POINTS},
                                             {"draco-mesh", v1::ENCODING_DRACO_MESH},
                                             {"quantised", v1::ENCODING_QUANTISED}}};
constexpr Names<v1::Pipeline, 4> kPipelines{{{"fused", v1::PIPELINE_FUSED},
                                             {"gemm", v1::PIPELINE_GEMM},
                                             {"gemm12", v1::PIPELINE_GEMM12},
                                             {"control-net", v1::PIPELINE_CONTROL_NET}}};

template <typename Enum, size_t N>
CLI::Validator OneOf(const Names<Enum, N>& names) {
  std::vector<std::string> words;
  for (const auto& [name, value] : names) words.emplace_back(name);
  return CLI::IsMember(words);
}

// UNSPECIFIED, which is 0, for an empty name: parsing has refused unknown ones.
template <typename Enum, size_t N>
Enum Find(const Names<Enum, N>& names, const std::string& word) {
  for (const auto& [name, value] : names) {
    if (name == word) return value;
  }
  return Enum{};
}

template <typename Enum, size_t N>
std::string NameOf(const Names<Enum, N>& names, Enum wanted) {
  for (const auto& [name, value] : names) {
    if (value == wanted) return name;
  }
  return "default";
}

CLI::Validator PositionBits() {
  return CLI::Range(limits::kMinPositionBits, limits::kMaxPositionBits);
}
CLI::Validator NormalBits() { return CLI::Range(limits::kMinNormalBits, limits::kMaxNormalBits); }

}  // namespace

void AddViewFlags(CLI::App& command, ViewFlags& flags) {
  command.add_option("--segments", flags.segments, "Subdivisions per patch edge")
      ->check(CLI::Range(limits::kMinSegments, limits::kMaxSegments));
  command.add_option("--normals", flags.normals, "Normals")->check(OneOf(kNormalModes));
  command.add_option("--encoding", flags.encoding, "How the surface is streamed")
      ->check(OneOf(kEncodings));
  command.add_option("--position-bits", flags.position_bits, "Bits per quantised coordinate")
      ->check(PositionBits());
  command.add_option("--normal-bits", flags.normal_bits, "Bits per quantised normal coordinate")
      ->check(NormalBits());
}

void AddDragFlags(CLI::App& command, ViewFlags& flags) {
  command.add_option("--max-points", flags.max_points,
                     "Most points of an update while edits come: fewer segments then");
  command.add_option("--max-bytes-per-second", flags.max_bytes_per_second,
                     "Most bytes a second while edits come: fewer segments then");
  command
      .add_option("--drag-position-bits", flags.drag_position_bits,
                  "--position-bits while a gesture is open")
      ->check(PositionBits());
  command
      .add_option("--drag-normal-bits", flags.drag_normal_bits,
                  "--normal-bits while a gesture is open")
      ->check(NormalBits());
}

v1::ViewOptions ToProto(const ViewFlags& flags) {
  v1::ViewOptions view;
  view.set_segments(flags.segments);
  view.set_normals(Find(kNormalModes, flags.normals));
  view.set_encoding(Find(kEncodings, flags.encoding));
  view.set_position_bits(flags.position_bits);
  view.set_normal_bits(flags.normal_bits);
  view.set_max_points(flags.max_points);
  view.set_max_bytes_per_second(flags.max_bytes_per_second);
  view.set_drag_position_bits(flags.drag_position_bits);
  view.set_drag_normal_bits(flags.drag_normal_bits);
  return view;
}

void AddPipelineFlag(CLI::App& command, std::string& pipeline) {
  command.add_option("--pipeline", pipeline, "How vertices are computed")->check(OneOf(kPipelines));
}

v1::Pipeline PipelineToProto(const std::string& pipeline) { return Find(kPipelines, pipeline); }

std::string EncodingName(v1::Encoding encoding) { return NameOf(kEncodings, encoding); }

std::string NormalModeName(v1::NormalMode normals) { return NameOf(kNormalModes, normals); }

}  // namespace latticed::client
