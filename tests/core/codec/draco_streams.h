// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Draco streams of libdraco's encoder that become much larger when they are read.
#ifndef LATTICED_TESTS_CORE_CODEC_DRACO_STREAMS_H_
#define LATTICED_TESTS_CORE_CODEC_DRACO_STREAMS_H_

#include <string>
#include <utility>
#include <vector>

namespace latticed::testing {

// The stream again by edgebreaker, libdraco's default for meshes.
[[nodiscard]] std::string EdgebreakerStream(const std::string& sequential);

// By name: attributes of many components, many attributes, attributes that differ at every corner, metadata; by both
// methods.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> CrowdedDracoStreams();

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_CORE_CODEC_DRACO_STREAMS_H_
