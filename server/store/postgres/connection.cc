// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/store/postgres/connection.h"

#include <array>
#include <utility>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/store/store_errors.h"

namespace latticed {
namespace {

// What the URL may replace. A connection on which nothing is acknowledged for so long is dead.
constexpr std::array<std::pair<const char*, const char*>, 5> kDefaults = {{
    {"connect_timeout", "3"},
    {"keepalives_idle", "1"},
    {"keepalives_interval", "1"},
    {"keepalives_count", "3"},
    {"tcp_user_timeout", "4000"},
}};

// A line for each address that was tried, without the hints below them.
std::string OneLine(std::string_view message) {
  const absl::string_view text(message.data(), message.size());
  const auto is_problem = [](absl::string_view line) {
    return !line.empty() && !absl::ascii_isspace(static_cast<unsigned char>(line.front()));
  };
  return absl::StrJoin(absl::StrSplit(text, '\n', is_problem), "; ");
}

// What the server's side of a connection does, so that no lock outlives a client whose host is gone.
constexpr char kSettings[] =
    "SET default_transaction_isolation = 'read committed'; SET tcp_keepalives_idle = 1; "
    "SET tcp_keepalives_interval = 1; SET tcp_keepalives_count = 3; SET tcp_user_timeout = 4000";

bool IsUri(std::string_view url) {
  return url.starts_with("postgresql://") || url.starts_with("postgres://");
}

// libpq ends the password at the first @ or /, takes the rest for a host or a port, and names those in its messages.
bool HasRawPassword(std::string_view url, const PQconninfoOption* options) {
  for (; options->keyword != nullptr; ++options) {
    if (options->val == nullptr || std::string_view(options->keyword) != "port") continue;
    if (std::string_view(options->val).find_first_not_of("0123456789,") != std::string_view::npos) {
      return true;
    }
  }
  if (!IsUri(url)) return false;
  url.remove_prefix(url.find("//") + 2);
  const size_t at = url.rfind('@');
  return at != std::string_view::npos && url.find_first_of("@/?#") < at;
}

bool IsFull(std::string_view state) {
  return state == "53100" || state == "53200";  // disk full, out of memory
}

}  // namespace

absl::Status PgConnection::CheckUrl(const std::string& url) {
  char* problem = nullptr;
  PQconninfoOption* options = PQconninfoParse(url.c_str(), &problem);
  const bool valid = options != nullptr && !absl::StripAsciiWhitespace(url).empty();
  const bool raw = valid && HasRawPassword(url, options);
  PQconninfoFree(options);
  PQfreemem(problem);  // it may repeat the password
  if (raw) {
    return absl::InvalidArgumentError(
        "percent-encode @, /, ? and # in the URL's user, password and options: %40, %2F, %3F, %23; "
        "and write a port as a number");
  }
  if (valid) return absl::OkStatus();
  return absl::InvalidArgumentError(
      "not a URL of PostgreSQL; write postgresql://user:password@host:5432/database");
}

absl::StatusOr<PgConnection> PgConnection::Open(const std::string& url) {
  LATTICED_RETURN_IF_ERROR(CheckUrl(url));
  std::vector<const char*> keys, values;
  for (const auto& [key, value] : kDefaults) {
    keys.push_back(key);
    values.push_back(value);
  }
  // Of a key that comes twice the last one counts.
  keys.insert(keys.end(), {"dbname", "fallback_application_name", "client_encoding", nullptr});
  values.insert(values.end(), {url.c_str(), "latticed", "UTF8", nullptr});
  PgConnection connection(PQconnectdbParams(keys.data(), values.data(), 1));
  if (connection.connection_ == nullptr) return error::StoreFailed("PostgreSQL: out of memory");
  PQsetNoticeProcessor(
      connection.connection_.get(), [](void*, const char*) {}, nullptr);
  if (connection.lost()) return connection.StatusOf(nullptr);
  LATTICED_RETURN_IF_ERROR(connection.Execute(kSettings));
  return connection;
}

absl::StatusOr<PgRows> PgConnection::Execute(const std::string& sql,
                                             const PgParameters& parameters) {
  auto found = prepared_.find(sql);
  if (found == prepared_.end()) {
    const std::string name = fmt::format("s{}", prepared_.size());
    const PgRows prepared(PQprepare(connection_.get(), name.c_str(), sql.c_str(),
                                    static_cast<int>(parameters.types_.size()),
                                    parameters.types_.data()));
    LATTICED_RETURN_IF_ERROR(StatusOf(prepared.result_.get()));
    found = prepared_.emplace(sql, name).first;
  }
  std::vector<const char*> values;
  std::vector<int> lengths;
  const std::vector<int> formats(parameters.values_.size(), 1);  // binary
  for (const std::string_view value : parameters.values_) {
    values.push_back(value.data() == nullptr ? "" : value.data());  // nullptr would be NULL
    lengths.push_back(static_cast<int>(value.size()));
  }
  PgRows rows(PQexecPrepared(connection_.get(), found->second.c_str(),
                             static_cast<int>(values.size()), values.data(), lengths.data(),
                             formats.data(), 1));
  LATTICED_RETURN_IF_ERROR(StatusOf(rows.result_.get()));
  return rows;
}

absl::Status PgConnection::Execute(const char* sql) {
  return StatusOf(PgRows(PQexec(connection_.get(), sql)).result_.get());
}

absl::Status PgConnection::StatusOf(const PGresult* result) {
  const ExecStatusType type = PQresultStatus(result);
  if (type == PGRES_COMMAND_OK || type == PGRES_TUPLES_OK) return absl::OkStatus();
  const char* state = PQresultErrorField(result, PG_DIAG_SQLSTATE);
  if (state == nullptr) unanswered_ = true;
  const char* primary = PQresultErrorField(result, PG_DIAG_MESSAGE_PRIMARY);
  const std::string problem = fmt::format(
      "PostgreSQL: {}", OneLine(primary == nullptr ? PQerrorMessage(connection_.get()) : primary));
  return state != nullptr && IsFull(state) ? error::StoreFull(problem)
                                           : error::StoreFailed(problem);
}

}  // namespace latticed
