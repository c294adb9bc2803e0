// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The input of http_fuzz: the bytes of a client, with "<cut>" between the pieces that it sends.
//
// Threads  pure
#ifndef LATTICED_TESTS_FUZZ_HTTP_INPUT_H_
#define LATTICED_TESTS_FUZZ_HTTP_INPUT_H_

#include <string>
#include <string_view>
#include <vector>

namespace latticed::fuzz {

[[nodiscard]] std::vector<std::string_view> Pieces(std::string_view input);

// The input with a Content-Length that is the length of the body, where the first request has one, and with a true
// length in the first frame of gRPC-Web. A mutation that changes a body would otherwise seldom reach its rpc.
[[nodiscard]] std::string WithTrueLengths(std::string_view input);

}  // namespace latticed::fuzz

#endif  // LATTICED_TESTS_FUZZ_HTTP_INPUT_H_
