// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/geometry/lattice_json.h"

#include <CLI/CLI.hpp>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_split.h"
#include "core/base/error.h"
#include "core/base/read_file.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "google/protobuf/util/json_util.h"

namespace latticed::client {
namespace {

void Set(const std::array<int, 3>& from, v1::LatticeAxes* to) {
  to->set_u(from[0]);
  to->set_v(from[1]);
  to->set_w(from[2]);
}

void Set(const std::vector<double>& from, google::protobuf::RepeatedField<double>* to) {
  to->Assign(from.begin(), from.end());
}

}  // namespace

v1::Vec3 ToProto(Vec3d from) {
  v1::Vec3 to;
  to.set_x(from.x);
  to.set_y(from.y);
  to.set_z(from.z);
  return to;
}

v1::Lattice ToProto(const Lattice& lattice) {
  v1::Lattice proto;
  const LatticeStructure& structure = lattice.structure;
  *proto.mutable_frame()->mutable_origin() = ToProto(structure.frame.origin);
  *proto.mutable_frame()->mutable_u() = ToProto(structure.frame.edges[0]);
  *proto.mutable_frame()->mutable_v() = ToProto(structure.frame.edges[1]);
  *proto.mutable_frame()->mutable_w() = ToProto(structure.frame.edges[2]);
  Set(structure.degree, proto.mutable_degree());
  Set(structure.size, proto.mutable_size());
  Set(structure.knots[0], proto.mutable_knots_u());
  Set(structure.knots[1], proto.mutable_knots_v());
  Set(structure.knots[2], proto.mutable_knots_w());
  for (const Vec3d p : lattice.control_points) {
    for (int axis = 0; axis < 3; ++axis) proto.add_control_points(p[axis]);
  }
  return proto;
}

absl::StatusOr<v1::Lattice> ReadLattice(const std::string& path) {
  LATTICED_ASSIGN_OR_RETURN(const auto json, ReadFile(path));
  v1::Lattice lattice;
  const auto status = google::protobuf::util::JsonStringToMessage(json, &lattice);
  if (!status.ok()) {
    return absl::InvalidArgumentError(
        fmt::format("{} is not the JSON of a lattice ('latticectl lattice' writes one): {}", path,
                    std::string(status.message())));
  }
  return lattice;
}

std::string CheckAxes(const std::string& text) {
  const std::vector<std::string> words = absl::StrSplit(text, ',');
  int number = 0;
  bool good = words.size() == 3;
  for (const std::string& word : words) good = good && absl::SimpleAtoi(word, &number);
  return good ? "" : fmt::format("'{}' is not three whole numbers such as 5,4,6", text);
}

void AddFitFlags(CLI::App& command, FitFlags& flags) {
  command.add_option("--size", flags.size, "Control points per axis")
      ->check(CheckAxes)
      ->capture_default_str();
  command.add_option("--degree", flags.degree, "Degree per axis, 1 to 3")
      ->check(CheckAxes)
      ->capture_default_str();
  command.add_option("--padding", flags.padding, "Margin as a fraction of the mesh's longest edge")
      ->capture_default_str();
}

v1::LatticeFit ToProto(const FitFlags& flags) {
  v1::LatticeFit fit;
  Set(ParseAxes(flags.size), fit.mutable_size());
  Set(ParseAxes(flags.degree), fit.mutable_degree());
  fit.set_padding(flags.padding);
  return fit;
}

std::array<int, 3> ParseAxes(const std::string& text) {
  const std::vector<std::string> words = absl::StrSplit(text, ',');
  std::array<int, 3> axes{};
  for (size_t i = 0; i < axes.size() && i < words.size(); ++i) {
    (void)absl::SimpleAtoi(words[i], &axes[i]);
  }
  return axes;
}

}  // namespace latticed::client
