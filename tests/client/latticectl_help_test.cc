// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The help of every command: it shows defaults, and ends with an example that can be parsed.
#include <CLI/CLI.hpp>

#include "absl/strings/str_split.h"
#include "client/cpp/latticectl/commands/commands.h"
#include "tests/client/latticectl_fixture.h"

namespace latticed::client {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;

// The words that name each command which does something, such as {"scene", "create"}.
std::vector<std::vector<std::string>> Commands() {
  std::ostringstream out, err;
  CLI::App app("", "latticectl");
  CommandLine line{.console = {.out = out, .err = err}};
  AddCommands(app, line);
  std::vector<std::vector<std::string>> found;
  for (const CLI::App* command : app.get_subcommands({})) {
    const auto below = command->get_subcommands({});
    for (const CLI::App* nested : below) {
      found.push_back({command->get_name(), nested->get_name()});
    }
    if (below.empty() || command->get_name() == "meshes") found.push_back({command->get_name()});
  }
  return found;
}

std::vector<std::string> ExampleOf(const std::string& help) {
  constexpr char kExample[] = "\nExample: latticectl ";
  const size_t at = help.find(kExample);
  if (at == std::string::npos) return {};
  const std::string words = help.substr(at + sizeof(kExample) - 1);
  EXPECT_THAT(words, EndsWith("\n"));
  return absl::StrSplit(words.substr(0, words.find('\n')), ' ');
}

class LatticectlHelp : public LatticectlTest {};

TEST_F(LatticectlHelp, OfEveryCommandEndsWithAnExampleThatParses) {
  const auto commands = Commands();
  EXPECT_EQ(commands.size(), 47u);
  for (const auto& command : commands) {
    SCOPED_TRACE(::testing::PrintToString(command));
    auto asks_for_help = command;
    asks_for_help.push_back("--help");
    std::vector<std::string> example = ExampleOf(MustRun(asks_for_help));
    ASSERT_GE(example.size(), command.size());
    EXPECT_TRUE(std::equal(command.begin(), command.end(), example.begin()));

    std::ostringstream out, err;
    CLI::App app("", "latticectl");
    CommandLine line{.console = {.out = out, .err = err}};
    AddCommands(app, line);
    std::reverse(example.begin(), example.end());  // the order in which CLI11 takes words
    EXPECT_NO_THROW(app.parse(example));
    EXPECT_TRUE(line.action);
  }
}

TEST_F(LatticectlHelp, ShowsDefaults) {
  const std::vector<std::pair<std::vector<std::string>, std::vector<std::string>>> cases{
      {{"apply"}, {"=10", "=raw", "=12", "=fused", "=auto"}},
      {{"scene", "create"}, {"=4,4,4", "=2,2,2", "=0.05", "=draco"}},
      {{"watch"}, {"=scene's", "=unlimited"}},
      {{"lattice"}, {"--twist", "--bend", "=0"}},
      {{"edit", "undo"}, {"=scene"}},
      {{"sample"}, {"=4", "beam always has 18"}}};
  for (const auto& [command, texts] : cases) {
    auto arguments = command;
    arguments.push_back("--help");
    const std::string help = MustRun(arguments);
    for (const std::string& text : texts) EXPECT_THAT(help, HasSubstr(text));
  }
}

TEST_F(LatticectlHelp, IsWhatAGroupWithoutACommandPrints) {
  EXPECT_EQ(MustRun({}), MustRun({"--help"}));
  EXPECT_EQ(MustRun({"scene"}), MustRun({"scene", "--help"}));
  EXPECT_EQ(MustRun({"edit"}), MustRun({"edit", "--help"}));
  EXPECT_THAT(MustRun({"scene"}), HasSubstr("Usage: latticectl scene"));
  EXPECT_THAT(MustRun({"scene"}), HasSubstr("create"));
}

}  // namespace
}  // namespace latticed::client
