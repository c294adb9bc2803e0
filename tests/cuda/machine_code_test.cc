// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Every kernel in this program, which holds the whole backend, is there in machine code for A100 and
// H100/H200, and in PTX for what comes after. Needs no device, and none of the tools that list what
// nvcc made, since a toolkit may come without them: reads it as they do.
//
//   a binary   magic (4 bytes), version (2), header bytes (2), bytes of its entries (8) | entry …
//   an entry   kind (2), – (2), header bytes (4), bytes (8), – (12), architecture (4) … | code
#include <elf.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "fmt/format.h"

namespace latticed::testing {
namespace {

// What cuda/find_cuda.cmake asks for where nobody asks for others.
constexpr std::string_view kUsual = "80-real,90-real,90-virtual";
// Magic, version and header bytes.
constexpr uint64_t kBegin = 0x0010'0001'ba55'ed50;

class Program {
 public:
  explicit Program(std::string bytes) : bytes_(std::move(bytes)) {}
  template <typename T>
  T At(size_t place) const {
    T value{};
    if (place + sizeof(T) <= bytes_.size()) std::memcpy(&value, bytes_.data() + place, sizeof(T));
    return value;
  }
  // Of no size where there is none of that name.
  Elf64_Shdr Section(std::string_view name) const {
    const auto file = At<Elf64_Ehdr>(0);
    const auto header = [&](size_t i) {
      return At<Elf64_Shdr>(file.e_shoff + i * sizeof(Elf64_Shdr));
    };
    const Elf64_Shdr names = header(file.e_shstrndx);
    for (size_t i = 0; i < file.e_shnum; ++i) {
      const size_t at = names.sh_offset + header(i).sh_name;
      if (at < bytes_.size() && name == bytes_.c_str() + at) return header(i);
    }
    return {};
  }

 private:
  std::string bytes_;
};

// "sm_80", "compute_90", …: what the entries are, from `at` to `end`.
std::vector<std::string> Entries(const Program& program, size_t at, size_t end) {
  std::vector<std::string> entries;
  while (at < end) {
    const auto kind = program.At<uint16_t>(at);
    const std::string_view prefix = kind == 1 ? "compute" : kind == 2 ? "sm" : "unknown";
    entries.push_back(fmt::format("{}_{}", prefix, program.At<uint32_t>(at + 28)));
    const uint64_t bytes = program.At<uint32_t>(at + 4) + program.At<uint64_t>(at + 8);
    if (bytes == 0) return {"damaged"};
    at += bytes;
  }
  return entries;
}

TEST(MachineCode, EveryKernelIsThereForBothArchitecturesAndForLaterOnes) {
  if (LATTICED_CUDA_ARCHITECTURES != kUsual) {
    GTEST_SKIP() << "configured for other architectures: " << LATTICED_CUDA_ARCHITECTURES;
  }
  std::ifstream file("/proc/self/exe", std::ios::binary);
  const Program program(std::string(std::istreambuf_iterator<char>(file), {}));
  const Elf64_Shdr section = program.Section(".nv_fatbin");
  const size_t end = section.sh_offset + section.sh_size;
  size_t binaries = 0;
  for (size_t at = section.sh_offset; at < end;) {
    if (program.At<uint64_t>(at) == 0) {  // between binaries
      at += 8;
      continue;
    }
    ASSERT_EQ(program.At<uint64_t>(at), kBegin) << "at " << at;
    const size_t first = at + 16;
    at = first + program.At<uint64_t>(at + 8);
    EXPECT_THAT(Entries(program, first, at),
                ::testing::UnorderedElementsAre("sm_80", "sm_90", "compute_90"));
    ++binaries;
  }
  EXPECT_GT(binaries, 10u) << "one a file of kernels";
}

}  // namespace
}  // namespace latticed::testing
