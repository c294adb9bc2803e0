// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// --ray, for commands that pick.
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_RAY_FLAGS_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_RAY_FLAGS_H_

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

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
  v1::Vec3& origin = *request.mutable_ray()->mutable_origin();
  v1::Vec3& direction = *request.mutable_ray()->mutable_direction();
  origin.set_x(ray[0]);
  origin.set_y(ray[1]);
  origin.set_z(ray[2]);
  direction.set_x(ray[3]);
  direction.set_y(ray[4]);
  direction.set_z(ray[5]);
  return request;
}

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_RAY_FLAGS_H_
