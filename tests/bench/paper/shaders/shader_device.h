// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
// The device that shaders run on. A GPU's row uses kCuda only. Tests also use Mesa's software
// renderer, which never counts as a GPU.
// use, is never taken for one.
#ifndef LATTICED_TESTS_BENCH_PAPER_SHADERS_SHADER_DEVICE_H_
#define LATTICED_TESTS_BENCH_PAPER_SHADERS_SHADER_DEVICE_H_

namespace latticed::bench {

enum class ShaderDevice {
  kCuda,  // CUDA device 0, with its vendor's own driver
  kAny,
};

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_PAPER_SHADERS_SHADER_DEVICE_H_
