// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The meshes that commands take: a name of 'latticectl sample', or a file.
//
// Errors   ReadMeshFile's; kInvalidArgument for a resolution that samples cannot have
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_SAMPLE_OR_FILE_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_SAMPLE_OR_FILE_H_

#include <string>

#include "absl/status/statusor.h"
#include "client/cpp/latticectl/files.h"
#include "core/mesh/sample_meshes.h"

namespace latticed::client {

// A sample mesh as the OBJ file that 'latticectl sample' writes, or the file of that name.
[[nodiscard]] absl::StatusOr<MeshFile> SampleOrFile(const std::string& name,
                                                    int resolution = kDefaultSampleResolution);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_SAMPLE_OR_FILE_H_
