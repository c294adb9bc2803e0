// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/edge/process_stats.h"

#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <string>
#include <system_error>

namespace latticed {
namespace {

// Fields of /proc/self/stat, counted from the state, which follows the program's name: proc(5).
constexpr size_t kThreads = 17, kStartTicks = 19, kVirtualBytes = 20, kResidentPages = 21;

std::array<uint64_t, kResidentPages + 1> ReadStat() {
  std::array<uint64_t, kResidentPages + 1> fields{};
  std::ifstream file("/proc/self/stat");
  file.ignore(std::numeric_limits<std::streamsize>::max(), ')');
  std::string word;
  for (uint64_t& field : fields) {
    if (!(file >> word)) break;
    field = std::strtoull(word.c_str(), nullptr, 10);  // the state is a letter: 0
  }
  return fields;
}

// Seconds since the epoch.
double BootTime() {
  std::ifstream file("/proc/stat");
  std::string word;
  while (file >> word) {
    double seconds = 0;
    if (word == "btime" && file >> seconds) return seconds;
  }
  return 0;
}

double Seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

}  // namespace

ProcessStats ReadProcessStats() {
  ProcessStats stats;
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  stats.cpu_seconds = Seconds(usage.ru_utime) + Seconds(usage.ru_stime);
  const auto fields = ReadStat();
  stats.threads = fields[kThreads];
  stats.virtual_bytes = fields[kVirtualBytes];
  stats.resident_bytes = fields[kResidentPages] * static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
  stats.start_time_seconds = BootTime() + static_cast<double>(fields[kStartTicks]) /
                                              static_cast<double>(sysconf(_SC_CLK_TCK));
  std::error_code none;
  const std::filesystem::directory_iterator files("/proc/self/fd", none);
  stats.open_files = static_cast<uint64_t>(std::distance(begin(files), end(files)));
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) == 0) stats.max_files = limit.rlim_cur;
  return stats;
}

}  // namespace latticed
