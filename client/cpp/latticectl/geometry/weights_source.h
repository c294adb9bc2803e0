// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The vertex weights that --weights names: those of the mesh's file, or those of a file of numbers.
//
//   attribute   the property weight of a PLY file, the attribute _WEIGHT of a GLB file
//   FILE        .npy or .csv (point_table.h): one number for each vertex, in the order of the mesh's vertices
//
// Errors   kInvalidArgument, and those of files.h
// Threads  pure functions
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_GEOMETRY_WEIGHTS_SOURCE_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_GEOMETRY_WEIGHTS_SOURCE_H_

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "latticed/v1/scene.pb.h"

namespace latticed::client {

inline constexpr char kWeightsOfMesh[] = "attribute";

// One float32, little endian, for each number of the file.
[[nodiscard]] absl::StatusOr<std::string> ReadWeights(const std::string& file);
// Sets the request's weights to those that `source` names. Empty: none.
[[nodiscard]] absl::Status SetWeights(const std::string& source, v1::CreateSceneRequest* request);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_GEOMETRY_WEIGHTS_SOURCE_H_
