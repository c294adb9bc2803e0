// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/json_output.h"

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "google/protobuf/util/json_util.h"

namespace latticed::client {

void AddJsonFlag(CLI::App& command, bool& json) { command.add_flag("--json", json, "Print JSON"); }

void PrintJson(const nlohmann::json& json, std::ostream& out) { out << json.dump(2) << '\n'; }

std::string MessageJson(const google::protobuf::Message& message) {
  google::protobuf::util::JsonPrintOptions options;
  options.add_whitespace = true;
  options.always_print_primitive_fields = true;  // a coordinate of 0 is written as well
  std::string json;
  (void)google::protobuf::util::MessageToJsonString(message, &json, options);
  return json;
}

}  // namespace latticed::client
