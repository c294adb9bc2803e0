// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Options that fill in a message of the protocol. An option that is not given leaves its field as it
// is; an empty field of a view takes the value of the scene's default view.
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_COMMAND_LINE_MESSAGE_FLAGS_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_COMMAND_LINE_MESSAGE_FLAGS_H_

#include <CLI/CLI.hpp>
#include <array>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "latticed/v1/mesh.pb.h"
#include "latticed/v1/scene.pb.h"
#include "latticed/v1/view.pb.h"

namespace latticed::client {

// Options that take one of a few names, each with a value.
template <typename Value, size_t N>
using NamedValues = std::array<std::pair<const char*, Value>, N>;

template <typename Value, size_t N>
std::string NameOf(const NamedValues<Value, N>& names, Value wanted, const char* otherwise) {
  for (const auto& [name, value] : names) {
    if (value == wanted) return name;
  }
  return otherwise;
}

// Calls `set` with the value of the name on the command line. `names` must outlive the command.
template <typename Value, size_t N>
CLI::Option* AddNamedOption(CLI::App& command, const std::string& option,
                            const NamedValues<Value, N>& names, std::function<void(Value)> set,
                            const std::string& text) {
  std::vector<std::string> words;
  for (const auto& [name, value] : names) words.emplace_back(name);
  const auto take = [&names, set = std::move(set)](const std::string& word) {
    for (const auto& [name, value] : names) {
      if (name == word) set(value);
    }
  };
  return command.add_option_function<std::string>(option, take, text)->check(CLI::IsMember(words));
}

// Where a field that is not given comes from. The help says it.
enum class ViewDefaults {
  kOfServer,  // for a new scene
  kOfScene,   // the default view of a scene that exists
};
// --segments, --normals, --encoding, --position-bits, --normal-bits.
void AddViewFlags(CLI::App& command, v1::ViewOptions& view, ViewDefaults defaults);
// Options that apply while edits come: --max-points, --max-bytes-per-second, --drag-…-bits.
void AddDragFlags(CLI::App& command, v1::ViewOptions& view);

// --pipeline: fused, gemm, gemm12, control-net.
void AddPipelineFlag(CLI::App& command, v1::Pipeline& pipeline);

// "draco", "raw", …: the name that --encoding takes.
[[nodiscard]] std::string EncodingName(v1::Encoding encoding);
[[nodiscard]] std::string NormalModeName(v1::NormalMode normals);

// --up-axis z, --meters-per-unit 0.001: the axis and the length unit of a mesh file.
void AddUnitsFlags(CLI::App& command, v1::MeshUnits& units);
// "x", "y", "z"; empty for an unknown one.
[[nodiscard]] std::string UpAxisName(v1::UpAxis axis);

// --crease-angle 30, in degrees.
void AddCreaseFlag(CLI::App& command, std::optional<double>& angle);

// --weights attribute|FILE: geometry/weights_source.h reads it.
void AddWeightsFlag(CLI::App& command, std::string& source);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_COMMAND_LINE_MESSAGE_FLAGS_H_
