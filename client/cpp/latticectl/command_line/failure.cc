// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/command_line/failure.h"

#include <CLI/CLI.hpp>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <ostream>
#include <string_view>
#include <vector>

#include "absl/strings/numbers.h"
#include "client/cpp/latticectl/command_line/did_you_mean.h"
#include "client/cpp/latticectl/command_line/field_flags.h"
#include "core/base/error.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

// Returns how a user can get past a refusal; empty where the message suffices.
std::string Advice(const error::Details& details) {
  const auto given = details.metadata.find(kAdviceKey);
  if (given != details.metadata.end()) return given->second;
  if (details.retry_after_ms > 0) {
    return fmt::format("try again in {:.3g} s", details.retry_after_ms / 1e3);
  }
  static const auto* const kAdvice = new std::map<std::string, std::string>{
      {"UNAUTHENTICATED", "give a token with --token or $LATTICED_TOKEN"},
      {"PERMISSION_DENIED", "use a token with that role"},
      {"OUT_OF_MEMORY",
       "take fewer --segments, or free memory with 'latticectl scene delete' and "
       "'latticectl meshes delete'"},
      {"MESH_IN_USE", "delete its scenes first, or all at once with --force"},
      {"REVISION_CHANGED", "run the command again"},
      {"STRUCTURE_CHANGED", "run the command again"}};
  const auto found = kAdvice->find(details.reason);
  if (found != kAdvice->end()) return found->second;
  const auto kind = details.metadata.find("kind");
  if (details.reason != "NOT_FOUND" || kind == details.metadata.end()) return "";
  if (kind->second == "scene") return "'latticectl scene list' shows what there is";
  return kind->second == "mesh" ? "'latticectl meshes' shows what there is" : "";
}

// Commands below `app`, without its option groups, which CLI11 keeps as commands without a name.
std::vector<std::string> CommandNames(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands({})) {
    if (!command->get_name().empty()) names.push_back(command->get_name());
  }
  return names;
}

std::vector<std::string> OptionNames(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    for (const std::string& name : option->get_snames()) names.push_back("-" + name);
  }
  for (const CLI::App* group : app.get_subcommands({})) {
    if (!group->get_name().empty()) continue;
    for (const std::string& name : OptionNames(*group)) names.push_back(name);
  }
  return names;
}

// "latticectl scene create"
std::string PathOf(const CLI::App& app) {
  const CLI::App* parent = app.get_parent();
  return parent == nullptr ? app.get_name() : PathOf(*parent) + " " + app.get_name();
}

// A word on the command line that is neither an option nor a command of `app`.
struct UnknownWord {
  const CLI::App* app;
  std::string word;
  bool is_option;
};

// Holds for "-3", and for a vector "-1,0,0".
bool IsNumber(const std::string& word) {
  double number = 0;
  return absl::SimpleAtod(word.substr(0, word.find(',')), &number);
}

std::optional<UnknownWord> FindUnknownWord(const CLI::App& app) {
  const bool wants_command = !CommandNames(app).empty() && app.get_subcommands().empty();
  for (const std::string& word : app.remaining()) {
    if (word.size() > 1 && word[0] == '-' && !IsNumber(word)) {
      return UnknownWord{&app, word.substr(0, word.find('=')), true};
    }
    if (wants_command) return UnknownWord{&app, word, false};
  }
  for (const CLI::App* command : app.get_subcommands()) {
    if (auto unknown = FindUnknownWord(*command)) return unknown;
  }
  return std::nullopt;
}

const CLI::App& DeepestCommand(const CLI::App& app) {
  const auto commands = app.get_subcommands();
  return commands.empty() ? app : DeepestCommand(*commands.back());
}

// A message begins with the field that it is about, if it is about one: "lattices[0].fit.degree.u: got 5, …".
std::string Message(const CLI::App& app, const std::string& message, const std::string& field) {
  const size_t end = field.empty() ? message.find(": ") : field.size();
  if (end == std::string::npos || !message.starts_with(field)) return message;
  const auto words = InWordsOf(DeepestCommand(app), message.substr(0, end));
  return words ? *words + message.substr(end) : message;
}

Failure WrongUsage(std::string message, std::string advice) {
  return {.message = std::move(message),
          .advice = std::move(advice),
          .code = absl::StatusCodeToString(absl::StatusCode::kInvalidArgument)};
}

Failure FailureOf(const UnknownWord& unknown) {
  const std::string path = PathOf(*unknown.app);
  const bool nested = unknown.app->get_parent() != nullptr && !unknown.is_option;
  const std::string group = nested ? unknown.app->get_name() + " " : "";
  const auto names = unknown.is_option ? OptionNames(*unknown.app) : CommandNames(*unknown.app);
  const std::string meant = DidYouMean(unknown.word, names);
  const char* const kind = unknown.is_option ? "option" : "command";
  return WrongUsage(fmt::format("unknown {} '{}{}'", kind, group, unknown.word),
                    meant.empty() ? fmt::format("'{} --help' shows the {}s", path, kind)
                                  : fmt::format("did you mean '{}{}'?", group, meant));
}

}  // namespace

Failure FailureOf(const absl::Status& status, const CLI::App& app) {
  const error::Details details = error::DetailsOf(status);
  const auto request = details.metadata.find("request_id");
  return {.message = Message(app, std::string(status.message()), details.field),
          .advice = Advice(details),
          .reason = details.reason,
          .code = absl::StatusCodeToString(status.code()),
          .field = details.field,
          .request_id = request == details.metadata.end() ? "" : request->second};
}

Failure FailureOf(const CLI::ParseError& error, const CLI::App& app) {
  // A misspelt option may be missed as a required one, which CLI11 reports first. Only exit codes tell errors apart.
  const auto code = static_cast<CLI::ExitCodes>(error.get_exit_code());
  const bool may_be_misspelt = code == CLI::ExitCodes::ExtrasError ||
                               code == CLI::ExitCodes::RequiredError ||
                               code == CLI::ExitCodes::RequiresError;
  if (may_be_misspelt) {
    if (const auto unknown = FindUnknownWord(app)) return FailureOf(*unknown);
  }
  return WrongUsage(error.what(),
                    fmt::format("'{} --help' says more", PathOf(DeepestCommand(app))));
}

void PrintNotice(const std::string& message, bool as_json, std::ostream& err) {
  if (as_json) {
    err << nlohmann::json{{"notice", {{"message", message}}}}.dump() << std::endl;
  } else {
    err << "latticectl: " << message << std::endl;
  }
}

void PrintFailure(const Failure& failure, bool as_json, std::ostream& err) {
  if (as_json) {
    auto members = nlohmann::json::object();
    const auto add = [&members](const char* name, const std::string& value) {
      if (!value.empty()) members[name] = value;
    };
    add("message", failure.message);
    add("advice", failure.advice);
    add("reason", failure.reason);
    add("code", failure.code);
    add("field", failure.field);
    add("requestId", failure.request_id);
    // Names of files and ids may hold bytes that are not UTF-8.
    constexpr auto kReplace = nlohmann::json::error_handler_t::replace;
    err << nlohmann::json{{"error", members}}.dump(-1, ' ', false, kReplace) << '\n';
    return;
  }
  err << "latticectl: " << failure.message;
  if (!failure.advice.empty()) err << "; " << failure.advice;
  std::string origin = failure.reason;
  if (!failure.request_id.empty()) {
    origin += (origin.empty() ? "request " : ", request ") + failure.request_id;
  }
  if (!origin.empty()) err << " (" << origin << ")";
  err << '\n';
}

}  // namespace latticed::client
