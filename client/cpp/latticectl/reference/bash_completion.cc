// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "absl/strings/str_join.h"
#include "client/cpp/latticectl/command_line/value_types.h"
#include "client/cpp/latticectl/reference/completion.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

// The script walks the words before the cursor. `command` becomes the command that they name, and `place` the number
// of its arguments so far. bash splits --option=value into three words.
constexpr char kBashWalk[] = R"(
  local word=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]} command=latticectl place=0 i
  if [[ $word == = ]]; then
    word=
  elif [[ $previous == = ]]; then
    previous=${COMP_WORDS[COMP_CWORD - 2]}
  fi
  for ((i = 1; i < COMP_CWORD; ++i)); do
    [[ ${COMP_WORDS[i]} == = || ${COMP_WORDS[i - 1]} == = ]] && continue
    if _latticectl_takes_value "$command ${COMP_WORDS[i - 1]}"; then
      continue
    elif _latticectl_is_command "$command ${COMP_WORDS[i]}"; then
      command+=" ${COMP_WORDS[i]}"
    elif [[ ${COMP_WORDS[i]} != -* ]]; then
      ((++place))
    fi
  done
)";

constexpr char kBashAnswer[] = R"(
  if [[ $kind == files || $kind == folders ]]; then
    compopt -o filenames 2>/dev/null
    local flag=-f
    [[ $kind == folders ]] && flag=-d
    mapfile -t COMPREPLY < <(compgen $flag -- "$word")
  else
    mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word")
  fi
}

complete -F _latticectl latticectl
)";

// Cases of a shell's "case": the body for each of the patterns.
std::string Case(const std::vector<std::string>& patterns, const std::string& body) {
  return patterns.empty() ? ""
                          : fmt::format("    {}) {} ;;\n", absl::StrJoin(patterns, " | "), body);
}

std::string BashQuoted(const std::string& text) { return fmt::format("'{}'", text); }

// A function that succeeds for the patterns.
std::string Predicate(const char* name, const std::vector<std::string>& patterns) {
  return fmt::format("_latticectl_{}() {{\n  case $1 in\n{}    *) return 1 ;;\n  esac\n}}\n\n",
                     name, Case(patterns, "return 0"));
}

std::string BashValues(const OptionEntry& option) {
  if (option.value == kFileType) return "kind=files";
  if (option.value == kFolderType) return "kind=folders";
  return fmt::format("words='{}'", absl::StrJoin(option.words, " "));
}

// What may follow each option that takes a value.
std::string OptionCases(const CommandEntry& command, std::vector<std::string>& with_values) {
  std::string cases;
  for (const OptionEntry& option : command.options) {
    if (!option.takes_value()) continue;
    std::vector<std::string> patterns;
    for (const std::string& name : option.names) {
      patterns.push_back(BashQuoted(command.path + " " + name));
    }
    cases += Case(patterns, BashValues(option));
    with_values.insert(with_values.end(), patterns.begin(), patterns.end());
  }
  return cases;
}

std::string ArgumentCases(const CommandEntry& command) {
  std::string cases;
  for (size_t place = 0; place < command.arguments.size(); ++place) {
    const OptionEntry& argument = command.arguments[place];
    const std::string at = argument.repeated ? " '*" : fmt::format(" {}'", place);
    cases += Case({"'" + command.path + at}, BashValues(argument));
  }
  return cases;
}

std::string WordsOf(const CommandEntry& command) {
  std::vector<std::string> words;
  for (const CommandEntry& below : command.commands) words.push_back(below.name());
  return words.empty() ? ""
                       : Case({BashQuoted(command.path + " 0")},
                              fmt::format("words='{}'", absl::StrJoin(words, " ")));
}

std::string OptionNames(const CommandEntry& command) {
  std::vector<std::string> names;
  for (const OptionEntry& option : command.options) {
    names.insert(names.end(), option.names.begin(), option.names.end());
  }
  return Case({BashQuoted(command.path)}, fmt::format("words='{}'", absl::StrJoin(names, " ")));
}

}  // namespace

std::string BashCompletion(const CommandEntry& program) {
  std::vector<std::string> with_values, commands;
  std::string values, arguments, options;
  for (const CommandEntry* command : AllCommands(program)) {
    if (command != &program) commands.push_back(BashQuoted(command->path));
    values += OptionCases(*command, with_values);
    arguments += WordsOf(*command) + ArgumentCases(*command);
    options += OptionNames(*command);
  }
  std::string script = "# Completion of latticectl in bash, by 'latticectl completion bash'.\n\n";
  script += Predicate("is_command", commands);
  script += Predicate("takes_value", with_values);
  script += "_latticectl() {";
  script += kBashWalk;
  script +=
      "  local kind=words words=\n  if _latticectl_takes_value \"$command $previous\"; then\n";
  script += "  case \"$command $previous\" in\n" + values + "  esac\n";
  script += "  elif [[ $word == -* ]]; then\n  case $command in\n" + options + "  esac\n";
  script += "  else\n  case \"$command $place\" in\n" + arguments + "  esac\n  fi";
  script += kBashAnswer;
  return script;
}

}  // namespace latticed::client
