// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Streams that the writer wrote in November 2026, in tests/client/golden, decode for ever.
// KIND_POINTS_POSITIONBITS_NORMALBITS_K.drc is a stream, and .points beside it what it must decode to: uint16 x y z 0 s t of
// each point. Of clouds there is a .meshopt too. The viewer and the Python package read them too.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "client/decoder/chunk_decoder.h"

namespace latticed::decoder {
namespace {

std::vector<uint8_t> ReadFile(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(GoldenStreamsTest, DecodeForEver) {
  int streams = 0;
  for (const auto& entry : std::filesystem::directory_iterator(LATTICED_CLIENT_GOLDEN)) {
    const std::filesystem::path& path = entry.path();
    if (path.extension() == ".points") continue;
    SCOPED_TRACE(path.filename().string());
    const std::string name = path.stem().string();
    uint32_t points = 0;
    ChunkForm form;
    form.codec = path.extension() == ".drc" ? Codec::kDraco : Codec::kMeshopt;
    ASSERT_EQ(std::sscanf(name.c_str(), "%*[a-z]_%u_%d_%d", &points, &form.position_bits,
                          &form.normal_bits),
              3);
    const std::vector<uint8_t> stream = ReadFile(path);
    const std::vector<uint8_t> bytes =
        ReadFile(std::filesystem::path(path).replace_extension(".points"));
    std::vector<uint16_t> expected(kNumbersPerPoint * points), decoded(expected.size());
    ASSERT_EQ(bytes.size(), expected.size() * sizeof(uint16_t));
    std::memcpy(expected.data(), bytes.data(), bytes.size());

    ChunkJob job{.stream = stream, .points = points, .out = decoded.data()};
    ChunkDecoder().Decode(form, {&job, 1});

    EXPECT_TRUE(job.decoded);
    EXPECT_EQ(decoded, expected);
    ++streams;
  }
  EXPECT_EQ(streams, 18 + 10);
}

}  // namespace
}  // namespace latticed::decoder
