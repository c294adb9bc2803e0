// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A kernel that traps, so that the device fails as it does on an invalid address.
#ifndef LATTICED_TESTS_CUDA_TRAP_KERNEL_H_
#define LATTICED_TESTS_CUDA_TRAP_KERNEL_H_

namespace latticed::testing {

// Traps on the current device and waits. Every later CUDA call of this process fails.
void TrapDevice();

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_CUDA_TRAP_KERNEL_H_
