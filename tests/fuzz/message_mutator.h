// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Changes one field of a protobuf message at random, so that the result still parses: bytes that are changed blindly
// seldom do.
#ifndef LATTICED_TESTS_FUZZ_MESSAGE_MUTATOR_H_
#define LATTICED_TESTS_FUZZ_MESSAGE_MUTATOR_H_

#include <random>

#include "google/protobuf/message.h"

namespace latticed::fuzz {

using Random = std::minstd_rand;

// A number below `end`, which is positive.
inline size_t Below(Random& random, size_t end) {
  return std::uniform_int_distribution<size_t>(0, end - 1)(random);
}

void MutateMessage(google::protobuf::Message& message, Random& random);

}  // namespace latticed::fuzz

#endif  // LATTICED_TESTS_FUZZ_MESSAGE_MUTATOR_H_
