// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Formats a load's report: as Markdown for people and documents, or as JSON for programs.
#ifndef LATTICED_CLIENT_CPP_LOAD_REPORT_OUTPUT_H_
#define LATTICED_CLIENT_CPP_LOAD_REPORT_OUTPUT_H_

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "client/cpp/latticectl/commands/load_plan.h"
#include "client/cpp/load/load_report.h"

namespace latticed::client {

// One section with a heading.
[[nodiscard]] std::string LoadMarkdown(const LoadPlan& plan, const LoadReport& report);
[[nodiscard]] nlohmann::json LoadJson(const LoadPlan& plan, const LoadReport& report);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LOAD_REPORT_OUTPUT_H_
