// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The query of an address, behind the '?': "segments=20&normals=smooth".
//
// Threads  pure functions
#ifndef LATTICED_SERVER_WEB_QUERY_PARAMETERS_H_
#define LATTICED_SERVER_WEB_QUERY_PARAMETERS_H_

#include <span>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "server/web/http_exchange.h"

namespace latticed::web {

// Names with their values unescaped, in order. kInvalidArgument for a name that is not among `known`,
// and for a value that is missing or escaped wrongly.
[[nodiscard]] absl::StatusOr<HttpFields> QueryParameters(const std::string& query,
                                                         std::span<const std::string_view> known);

}  // namespace latticed::web

#endif  // LATTICED_SERVER_WEB_QUERY_PARAMETERS_H_
