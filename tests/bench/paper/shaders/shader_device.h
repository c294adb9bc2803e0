// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Where shaders run. A row of a GPU comes from kCuda alone: Mesa's software renderer, which tests
// use, is never taken for one.
#ifndef LATTICED_TESTS_BENCH_PAPER_SHADERS_SHADER_DEVICE_H_
#define LATTICED_TESTS_BENCH_PAPER_SHADERS_SHADER_DEVICE_H_

namespace latticed::bench {

enum class ShaderDevice {
  kCuda,  // the CUDA device 0, under its vendor's own driver
  kAny,
};

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_PAPER_SHADERS_SHADER_DEVICE_H_
