// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The compressed copies of a file that the viewer's build leaves beside it, and which of them a client takes
// (RFC 9110, 12.5.3).
//
// Threads  pure functions
#ifndef LATTICED_SERVER_WEB_CONTENT_CODING_H_
#define LATTICED_SERVER_WEB_CONTENT_CODING_H_

#include <string_view>
#include <vector>

namespace latticed::web {

struct ContentCoding {
  std::string_view name;    // in Accept-Encoding and Content-Encoding
  std::string_view suffix;  // of the copy's file name: "main.js.br"
};

// The codings that a client prefers to the file as it is, best first. Empty for a client that names none.
[[nodiscard]] std::vector<ContentCoding> AcceptedCodings(std::string_view accept_encoding);

}  // namespace latticed::web

#endif  // LATTICED_SERVER_WEB_CONTENT_CODING_H_
