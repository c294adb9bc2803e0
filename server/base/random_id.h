// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Ids that nobody can guess: whoever knows an id may use what it names.
//
// Threads  safe
#ifndef LATTICED_SERVER_BASE_RANDOM_ID_H_
#define LATTICED_SERVER_BASE_RANDOM_ID_H_

#include <string>

namespace latticed {

// 128 random bits, 32 hex digits.
[[nodiscard]] std::string NewRandomId();

}  // namespace latticed

#endif  // LATTICED_SERVER_BASE_RANDOM_ID_H_
