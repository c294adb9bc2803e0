// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How many threads a backend may use.
#ifndef LATTICED_CORE_VIEW_ALLOWED_THREADS_H_
#define LATTICED_CORE_VIEW_ALLOWED_THREADS_H_

namespace latticed {

// `asked` where above 0, else all that the affinity mask and the cgroup allow.
[[nodiscard]] int AllowedThreads(int asked);

}  // namespace latticed

#endif  // LATTICED_CORE_VIEW_ALLOWED_THREADS_H_
