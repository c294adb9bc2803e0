// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The threads and the memory of this machine.
#ifndef LATTICED_CORE_VIEW_MACHINE_H_
#define LATTICED_CORE_VIEW_MACHINE_H_

#include <cstddef>

namespace latticed {

// `asked` where above 0, else all that the affinity mask and the cgroup allow.
[[nodiscard]] int AllowedThreads(int asked);

// Bytes of memory, by sysconf's _SC_PHYS_PAGES (all) or _SC_AVPHYS_PAGES (free). 0: unknown.
[[nodiscard]] size_t MachineBytes(int pages_name);

}  // namespace latticed

#endif  // LATTICED_CORE_VIEW_MACHINE_H_
