// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/web/query_parameters.h"

#include <algorithm>
#include <string>

#include "absl/strings/str_split.h"
#include "core/base/error.h"
#include "fmt/format.h"
#include "server/web/http_answers.h"

namespace latticed::web {

absl::StatusOr<HttpFields> QueryParameters(const std::string& query,
                                           std::span<const std::string_view> known) {
  HttpFields parameters;
  for (const auto pair : absl::StrSplit(query, '&', absl::SkipEmpty())) {
    const std::string text(pair);
    const size_t equals = std::min(text.find('='), text.size());
    const std::string name = text.substr(0, equals);
    if (std::ranges::find(known, name) == known.end()) {
      return error::InvalidField(
          "query", fmt::format("'{}' is none of its parameters: {}", name, fmt::join(known, ", ")));
    }
    if (std::ranges::find(parameters, name, &HttpField::name) != parameters.end()) {
      return error::InvalidField("query", fmt::format("'{}' is there twice", name));
    }
    std::string value;
    if (equals == text.size() || !PercentDecode(text.substr(equals + 1), &value)) {
      return error::InvalidField("query", fmt::format("'{}' has no value that can be read", text));
    }
    parameters.push_back({name, value});
  }
  return parameters;
}

}  // namespace latticed::web
