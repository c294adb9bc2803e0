// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/view/machine.h"

#include <tbb/info.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <string>

namespace latticed {
namespace {

// The processors that a container may use, rounded up: "max 100000" or "150000 100000" in cgroup
// v2. oneTBB 2021 looks at the affinity mask only.
int CgroupThreads(int most) {
  std::ifstream file("/sys/fs/cgroup/cpu.max");
  std::string quota;
  long period = 0;
  if (!(file >> quota >> period) || quota == "max" || period <= 0) return most;
  const long allowed = std::strtol(quota.c_str(), nullptr, 10);
  return static_cast<int>(std::clamp<long>((allowed + period - 1) / period, 1, most));
}

}  // namespace

int AllowedThreads(int asked) {
  return asked > 0 ? asked : CgroupThreads(std::max(1, tbb::info::default_concurrency()));
}

size_t MachineBytes(int pages_name) {
  const long pages = sysconf(pages_name), size = sysconf(_SC_PAGESIZE);
  return pages > 0 && size > 0 ? static_cast<size_t>(pages) * static_cast<size_t>(size) : 0;
}

}  // namespace latticed
