// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The textures of the viewer's shader, as its header describes them, in host memory.
#ifndef LATTICED_TESTS_CLIENT_PATCHES_SHADER_SHADER_TEXTURES_H_
#define LATTICED_TESTS_CLIENT_PATCHES_SHADER_SHADER_TEXTURES_H_

#include <array>
#include <cstdint>
#include <vector>

#include "core/base/vec.h"
#include "tests/core/patches/patch_scene.h"

namespace latticed::testing {

struct ShaderTextures {
  std::vector<int32_t> patches, seams;  // four numbers a texel
  std::vector<float> boxes, normals;
  std::array<int32_t, 3> box_steps{};
  std::array<float, 9> conormals{};  // by column
};

[[nodiscard]] ShaderTextures MakeShaderTextures(const PatchScene& scene);

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_CLIENT_PATCHES_SHADER_SHADER_TEXTURES_H_
