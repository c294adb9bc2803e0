// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/reference/man_page.h"

#include <map>

#include "absl/strings/ascii.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

constexpr char kExitStatus[] = R"(.SH EXIT STATUS
.TP
.B 0
Done.
.TP
.B 1
Failed.
.TP
.B 2
Wrong usage.
.TP
.B 130\fR, \fB143
Interrupted by SIGINT or SIGTERM, after temporary scenes and meshes were deleted.
)";

// Text as groff prints it. A line must not begin with a control character.
std::string Roff(const std::string& text) {
  std::string escaped = absl::StrReplaceAll(text, {{"\\", "\\e"}, {"-", "\\-"}, {"'", "\\(aq"}});
  if (escaped.starts_with('.')) escaped = "\\&" + escaped;
  return absl::StrReplaceAll(escaped, {{"\n.", "\n\\&."}});
}

std::string Bold(const std::string& text) { return "\\fB" + Roff(text) + "\\fR"; }
std::string Italic(const std::string& text) { return "\\fI" + Roff(text) + "\\fR"; }

// "Text." where CLI11's texts have no full stop.
std::string Sentence(const std::string& text) {
  return Roff(text) + (text.ends_with('.') || text.empty() ? "" : ".");
}

// A footer ends with an example, which is no sentence.
std::string FooterText(const std::string& text) {
  return absl::StrReplaceAll(Roff(text), {{"\n\n", "\n.PP\n"}}) + "\n";
}

std::string ValueText(const OptionEntry& option) {
  return option.words.empty() ? Italic(option.value) : Bold(absl::StrJoin(option.words, "|"));
}

std::string ArgumentIn(const OptionEntry& argument) {
  const std::string name = Italic(argument.names[0]) + (argument.repeated ? "..." : "");
  return argument.required ? name : "[" + name + "]";
}

// Facts that the text does not say: "Value: INT in [1 - 32]. Default: 10."
std::string Facts(const OptionEntry& option) {
  std::string facts;
  if (!option.range.empty()) facts += fmt::format(" Value: {}.", Roff(option.range));
  if (!option.default_value.empty()) {
    facts += fmt::format(" Default: {}.", Bold(option.default_value));
  }
  if (!option.environment.empty())
    facts += fmt::format(" Environment: {}.", Bold(option.environment));
  if (option.required) facts += " Required.";
  return facts;
}

std::string Item(const std::string& head, const OptionEntry& option) {
  return ".TP\n" + head + "\n" + Sentence(option.text) + Facts(option) + "\n";
}

std::string Items(const CommandEntry& command) {
  std::string items;
  for (const OptionEntry& argument : command.arguments) {
    std::string head = Italic(argument.names[0]);
    if (!argument.words.empty()) head += " " + ValueText(argument);
    items += Item(head, argument);
  }
  for (const OptionEntry& option : command.options) {
    std::vector<std::string> names;
    for (const std::string& name : option.names) names.push_back(Bold(name));
    std::string head = absl::StrJoin(names, ", ");
    if (option.takes_value()) head += " " + ValueText(option);
    items += Item(head, option);
  }
  return items;
}

std::string Usage(const CommandEntry& command) {
  std::string usage = Bold(command.path) + " [" + Italic("OPTIONS") + "]";
  for (const OptionEntry& argument : command.arguments) usage += " " + ArgumentIn(argument);
  if (!command.commands.empty()) usage += " " + Italic("COMMAND");
  return usage + "\n";
}

std::string Environment(const CommandEntry& program) {
  std::map<std::string, std::string> replaced;  // options by variable
  for (const CommandEntry* command : AllCommands(program)) {
    for (const OptionEntry& option : command->options) {
      if (!option.environment.empty()) replaced[option.environment] = option.names.back();
    }
  }
  std::string text;
  for (const auto& [variable, option] : replaced) {
    text += ".TP\n" + Bold(variable) + "\nIs used where " + Bold(option) + " is not given.\n";
  }
  return text;
}

}  // namespace

std::string ManPage(const CommandEntry& program, std::string_view version) {
  std::string page = fmt::format(".TH {} 1 \"\" \"latticed {}\" \"latticed\"\n",
                                 absl::AsciiStrToUpper(program.path), version);
  page += ".SH NAME\n" + Roff(program.path) + " \\- " + Roff(program.text) + "\n";
  page += ".SH SYNOPSIS\n" + Usage(program);
  page += ".SH OPTIONS\n" + Items(program);
  page += ".SH COMMANDS\n";
  for (const CommandEntry* command : AllCommands(program)) {
    if (command == &program) continue;
    page += ".SS " + Roff(command->path.substr(program.path.size() + 1)) + "\n" + Usage(*command) +
            ".PP\n" + Sentence(command->text) + "\n" + Items(*command);
    if (!command->footer.empty()) page += ".PP\n" + FooterText(command->footer);
  }
  page += ".SH ENVIRONMENT\n" + Environment(program) + kExitStatus;
  return page;
}

}  // namespace latticed::client
