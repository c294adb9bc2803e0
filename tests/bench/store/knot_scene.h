// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A scene of 5,760 faces in a lattice of 512 control points, through a real client.
#ifndef LATTICED_TESTS_BENCH_STORE_KNOT_SCENE_H_
#define LATTICED_TESTS_BENCH_STORE_KNOT_SCENE_H_

#include <string>

#include "client/cpp/library/latticed_client.h"

namespace latticed::bench {

inline constexpr int kKnotPoints = 8 * 8 * 8;

// Returns the mesh's id.
[[nodiscard]] std::string UploadKnot(client::Client& client);
void CreateKnotScene(client::Client& client, const std::string& mesh, const std::string& scene);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_STORE_KNOT_SCENE_H_
