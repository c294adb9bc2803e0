// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "client/cpp/latticectl/command_line/value_types.h"
#include "client/cpp/latticectl/reference/completion.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

constexpr char kZshHead[] = R"(#compdef latticectl
# Completion of latticectl in zsh, by 'latticectl completion zsh'.

)";

// As a file of $fpath the script is the function itself. Sourced, it declares the function.
constexpr char kZshEnd[] = R"(if [[ $funcstack[1] == _latticectl ]]; then
  _latticectl "$@"
else
  compdef _latticectl latticectl
fi
)";

std::string FunctionOf(const CommandEntry& command) {
  return "_" + absl::StrReplaceAll(command.path, {{" ", "_"}, {"-", "_"}});
}

std::string ZshQuoted(const std::string& text) {
  return "'" + absl::StrReplaceAll(text, {{"'", "'\\''"}}) + "'";
}

// Text in a specification of _arguments or _describe.
std::string ZshEscaped(const std::string& text) {
  return absl::StrReplaceAll(text, {{"\\", "\\\\"}, {"[", "\\["}, {"]", "\\]"}, {":", "\\:"}});
}

// ":what:how to complete it"
std::string ZshValue(const OptionEntry& option, const std::string& what) {
  std::string action = " ";
  if (option.value == kFileType) action = "_files";
  if (option.value == kFolderType) action = "_files -/";
  if (!option.words.empty()) action = "(" + absl::StrJoin(option.words, " ") + ")";
  return ":" + ZshEscaped(what) + ":" + action;
}

std::string OptionSpecs(const OptionEntry& option) {
  const std::string others = option.repeated ? "*" : "(" + absl::StrJoin(option.names, " ") + ")";
  std::string specs;
  for (const std::string& name : option.names) {
    std::string spec = others + name;
    if (option.takes_value() && name.starts_with("--")) spec += '=';
    spec += "[" + ZshEscaped(option.text) + "]";
    if (option.takes_value()) spec += ZshValue(option, option.value);
    specs += " \\\n    " + ZshQuoted(spec);
  }
  return specs;
}

std::string ArgumentSpec(const OptionEntry& argument) {
  const std::string place = argument.repeated ? "*" : (argument.required ? "" : ":");
  return " \\\n    " + ZshQuoted(place + ZshValue(argument, argument.names[0]));
}

// The part of a group's function that completes the group's commands, and their own words.
std::string Dispatch(const CommandEntry& group) {
  std::string names, cases;
  for (const CommandEntry& below : group.commands) {
    names += "\n        " + ZshQuoted(below.name() + ":" + ZshEscaped(below.text));
    cases += fmt::format("        {}) {} ;;\n", below.name(), FunctionOf(below));
  }
  return "  case $state in\n    command)\n      local -a commands=(" + names +
         "\n      )\n      _describe command commands ;;\n    words)\n      case $line[1] in\n" +
         cases + "      esac ;;\n  esac\n";
}

std::string Function(const CommandEntry& command) {
  const bool is_group = !command.commands.empty();
  std::string text = FunctionOf(command) + "() {\n";
  if (is_group) text += "  local curcontext=$curcontext state line\n";
  text += is_group ? "  _arguments -C" : "  _arguments";
  for (const OptionEntry& option : command.options) text += OptionSpecs(option);
  for (const OptionEntry& argument : command.arguments) text += ArgumentSpec(argument);
  if (is_group) text += " \\\n    '1: :->command' \\\n    '*:: :->words'";
  text += "\n";
  if (is_group) text += Dispatch(command);
  return text + "}\n\n";
}

}  // namespace

std::string ZshCompletion(const CommandEntry& program) {
  std::string script = kZshHead;
  for (const CommandEntry* command : AllCommands(program)) script += Function(*command);
  return script + kZshEnd;
}

}  // namespace latticed::client
