// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Prints a load's report for people, for documents and for programs.
//
// Threads  pure functions
#ifndef LATTICED_CLIENT_CPP_LOAD_REPORT_OUTPUT_H_
#define LATTICED_CLIENT_CPP_LOAD_REPORT_OUTPUT_H_

#include <iosfwd>
#include <string>

#include "client/cpp/load/load_plan.h"
#include "client/cpp/load/load_report.h"

namespace latticed::client {

void PrintLoadText(const LoadPlan& plan, const LoadReport& report, std::ostream& out);
void PrintLoadJson(const LoadPlan& plan, const LoadReport& report, std::ostream& out);
// A section with a heading.
[[nodiscard]] std::string LoadMarkdown(const LoadPlan& plan, const LoadReport& report);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LOAD_REPORT_OUTPUT_H_
