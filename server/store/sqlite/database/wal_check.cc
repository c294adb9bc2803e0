// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/store/sqlite/database/wal_check.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <span>

#include "fmt/format.h"
#include "server/store/sqlite/database/checked_vfs.h"
#include "server/store/store_errors.h"

namespace latticed {
namespace {

constexpr size_t kWalHeaderBytes = 32;
constexpr size_t kFrameHeaderBytes = 24;
constexpr uint32_t kWalMagic = 0x377f0682;  // the lowest bit: words of checksums are big-endian
constexpr int kMostCutCommits = 1;

using FrameBytes = std::array<char, kFrameHeaderBytes + kDatabasePageBytes>;

uint32_t BigEndian(const char* bytes) {
  uint32_t value = 0;
  for (int i = 0; i < 4; ++i) value = value << 8 | static_cast<uint8_t>(bytes[i]);
  return value;
}

// The running checksum of a log: s0 += x[0] + s1, s1 += x[1] + s0 over pairs of words.
struct WalSum {
  uint32_t s0 = 0;
  uint32_t s1 = 0;

  bool operator==(const WalSum&) const = default;

  void Add(std::span<const char> bytes, bool big_endian) {
    const auto word = [&](size_t at) {
      const uint32_t value = BigEndian(bytes.data() + at);
      return big_endian ? value : __builtin_bswap32(value);
    };
    for (size_t i = 0; i < bytes.size(); i += 8) {
      s0 += word(i) + s1;
      s1 += word(i + 4) + s0;
    }
  }
};

WalSum StoredSum(const char* bytes) { return {BigEndian(bytes), BigEndian(bytes + 4)}; }

}  // namespace

absl::Status CheckWal(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file && errno == ENOENT) return absl::OkStatus();
  if (!file) return error::StoreFailed(fmt::format("{}: {}", path, std::strerror(errno)));
  std::array<char, kWalHeaderBytes> header;
  // A file that was made and not written yet is shorter, or has zeros.
  if (!file.read(header.data(), header.size())) return absl::OkStatus();
  if (std::ranges::all_of(header, [](char byte) { return byte == 0; })) return absl::OkStatus();

  const bool big_endian = (BigEndian(header.data()) & 1) != 0;
  WalSum sum;
  sum.Add(std::span(header).first(kWalHeaderBytes - 8), big_endian);
  if ((BigEndian(header.data()) & ~1U) != kWalMagic || sum != StoredSum(header.data() + 24) ||
      BigEndian(header.data() + 8) != kDatabasePageBytes) {
    return error::Damaged(path, "its header is not that of a log; commits in it would be lost");
  }

  int cut_commits = 0;
  uint64_t first_bad = 0;
  FrameBytes frame;
  for (uint64_t number = 1; file.read(frame.data(), frame.size()); ++number) {
    const bool of_this_log = std::memcmp(frame.data() + 8, header.data() + 16, 8) == 0;
    if (first_bad == 0) {
      sum.Add(std::span(frame).first(8), big_endian);
      sum.Add(std::span(frame).subspan(kFrameHeaderBytes), big_endian);
      if (!of_this_log || sum != StoredSum(frame.data() + 16)) first_bad = number;
    }
    const bool commit = BigEndian(frame.data() + 4) != 0;
    if (first_bad != 0 && of_this_log && commit && ++cut_commits > kMostCutCommits) {
      return error::Damaged(path, fmt::format("frame {} is not what was written; commits after it "
                                              "would be lost",
                                              first_bad));
    }
  }
  return absl::OkStatus();
}

}  // namespace latticed
