// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A load's report for people, for documents and for programs.
//
// Threads  pure functions
#ifndef LATTICED_CLIENT_CPP_LOAD_REPORT_OUTPUT_H_
#define LATTICED_CLIENT_CPP_LOAD_REPORT_OUTPUT_H_

#include <iosfwd>
#include <string>

#include "client/cpp/load/load_plan.h"
#include "client/cpp/load/load_report.h"

namespace latticed::client {

// "2 scenes of knot, 1 editor and 20 watchers each, …".
[[nodiscard]] std::string LoadTitle(const LoadPlan& plan, const LoadReport& report);
void PrintLoadText(const LoadPlan& plan, const LoadReport& report, std::ostream& out);
void PrintLoadJson(const LoadPlan& plan, const LoadReport& report, std::ostream& out);
// A section, its heading the title.
[[nodiscard]] std::string LoadMarkdown(const LoadPlan& plan, const LoadReport& report);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LOAD_REPORT_OUTPUT_H_
