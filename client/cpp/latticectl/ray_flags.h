// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// --ray, for commands that pick.
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_RAY_FLAGS_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_RAY_FLAGS_H_

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "client/cpp/latticectl/lattice_json.h"
#include "latticed/v1/surface.pb.h"

namespace latticed::client {

// Six numbers: where the ray begins and where it goes.
inline CLI::Option* AddRayFlag(CLI::App& command, std::vector<double>& ray) {
  return command
      .add_option("--ray", ray, "Ray X,Y,Z,DX,DY,DZ in the world: where it begins, where it goes")
      ->delimiter(',')
      ->expected(6);
}

inline v1::PickRequest PickRequestOf(const std::string& scene, const std::vector<double>& ray) {
  v1::PickRequest request;
  request.set_scene(scene);
  *request.mutable_ray()->mutable_origin() = ToProto(Vec3d{ray[0], ray[1], ray[2]});
  *request.mutable_ray()->mutable_direction() = ToProto(Vec3d{ray[3], ray[4], ray[5]});
  return request;
}

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_RAY_FLAGS_H_
