// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// --json: messages of the protocol as proto3 JSON, one document per command, for programs.
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_JSON_OUTPUT_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_JSON_OUTPUT_H_

#include <nlohmann/json_fwd.hpp>
#include <ostream>
#include <string>
#include <vector>

#include "google/protobuf/message.h"

namespace CLI {
class App;
}

namespace latticed::client {

void AddJsonFlag(CLI::App& command, bool& json);
void PrintJson(const nlohmann::json& json, std::ostream& out);
[[nodiscard]] std::string MessageJson(const google::protobuf::Message& message);

template <typename Message>
void PrintJsonArray(const std::vector<Message>& messages, std::ostream& out) {
  out << '[';
  for (size_t i = 0; i < messages.size(); ++i) {
    out << (i == 0 ? "\n" : ",\n") << MessageJson(messages[i]);
  }
  out << "]\n";
}

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_JSON_OUTPUT_H_
