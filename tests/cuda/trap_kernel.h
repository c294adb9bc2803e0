// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A kernel that the device gives up on, as on an address that is none.
#ifndef LATTICED_TESTS_CUDA_TRAP_KERNEL_H_
#define LATTICED_TESTS_CUDA_TRAP_KERNEL_H_

namespace latticed::testing {

// On the current device; waits. Whatever CUDA is asked by this process afterwards fails.
void TrapDevice();

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_CUDA_TRAP_KERNEL_H_
