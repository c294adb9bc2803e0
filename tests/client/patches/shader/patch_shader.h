// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The viewer's shader (client/web/src/patches/evaluate_patch.vert) without a browser: the textures that its header
// describes, and transform feedback into memory.
//
// Errors   kInternal with the message of OpenGL
// Threads  only the context's thread
#ifndef LATTICED_TESTS_CLIENT_PATCHES_SHADER_PATCH_SHADER_H_
#define LATTICED_TESTS_CLIENT_PATCHES_SHADER_PATCH_SHADER_H_

#include <string>

#include "absl/status/statusor.h"
#include "client/cpp/library/patches/patch_evaluator.h"
#include "tests/core/patches/patch_scene.h"

namespace latticed::testing {

// Evaluates the points of `surface`, whose patterns are chosen, and returns it with the shader's positions and normals.
// `text` is the shader's source.
[[nodiscard]] absl::StatusOr<client::PatchSurface> EvaluateByShader(const PatchScene& scene,
                                                                    const std::string& text,
                                                                    client::PatchSurface surface);

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_CLIENT_PATCHES_SHADER_PATCH_SHADER_H_
