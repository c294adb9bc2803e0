// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The completions and the manual page have every command and option, and bash and groff take them.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>

#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "client/cpp/latticectl/commands/bench_flags.h"
#include "client/cpp/latticectl/commands/commands.h"
#include "client/cpp/latticectl/reference/command_table.h"
#include "fmt/format.h"
#include "tests/client/latticectl_fixture.h"

namespace latticed::client {
namespace {

using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::IsSupersetOf;
using ::testing::StartsWith;
using ::testing::UnorderedElementsAreArray;

// The commands as they are parsed, bench by the load generator.
CommandEntry DeclaredCommands() {
  std::ostringstream out, err;
  CLI::App app("", "latticectl");
  app.set_version_flag("--version", "");
  CommandLine line{.console = {.out = out, .err = err}};
  AddCommands(app, line);
  CommandEntry table = TableOf(app);
  CLI::App bench("", "latticectl bench");
  BenchFlags flags;
  DeclareBench(bench, flags);
  std::ranges::find(table.commands, "latticectl bench", &CommandEntry::path)->options =
      TableOf(bench).options;
  return table;
}

std::vector<std::string> OptionNames(const CommandEntry& command) {
  std::vector<std::string> names;
  for (const OptionEntry& option : command.options) {
    names.insert(names.end(), option.names.begin(), option.names.end());
  }
  return names;
}

// What a command of bash prints, its errors included.
std::string Output(const std::string& command) {
  std::string text;
  std::array<char, 4096> buffer{};
  FILE* const pipe = popen((command + " 2>&1").c_str(), "r");
  while (const size_t bytes = fread(buffer.data(), 1, buffer.size(), pipe)) {
    text.append(buffer.data(), bytes);
  }
  EXPECT_EQ(pclose(pipe), 0) << command << text;
  return text;
}

class LatticectlReference : public LatticectlTest {
 protected:
  // What bash offers for the last word of each line, one after the other, in the test's folder.
  std::vector<std::vector<std::string>> Completed(
      const std::vector<std::vector<std::string>>& lines) const {
    std::string script = MustRun({"completion", "bash"}) + fmt::format("cd '{}'\n", Path(""));
    script +=
        "complete_line() { COMP_WORDS=(\"$@\") COMP_CWORD=$(($# - 1)) COMPREPLY=(); _latticectl; "
        "local IFS=/; echo \"${COMPREPLY[*]}\"; }\n";
    for (const auto& words : lines) {
      script += fmt::format("complete_line '{}'\n", absl::StrJoin(words, "' '"));
    }
    EXPECT_OK(WriteFile(Path("script.bash"), script));
    const std::string text = Output(fmt::format("bash -u '{}'", Path("script.bash")));
    std::vector<std::vector<std::string>> offers;
    for (const auto line : absl::StrSplit(text, '\n')) {
      offers.push_back(absl::StrSplit(line, '/', absl::SkipEmpty()));
    }
    offers.pop_back();  // after the last line's end
    EXPECT_EQ(offers.size(), lines.size()) << text;
    offers.resize(lines.size());
    return offers;
  }
};

TEST_F(LatticectlReference, BashOffersEveryOptionOfEveryCommand) {
  const CommandEntry program = DeclaredCommands();
  const auto commands = AllCommands(program);
  std::vector<std::vector<std::string>> lines;
  for (const CommandEntry* command : commands) {
    lines.push_back(absl::StrSplit(command->path, ' '));
    lines.back().push_back("-");
  }

  const auto offers = Completed(lines);

  ASSERT_EQ(commands.size(), 53u);
  for (size_t i = 0; i < commands.size(); ++i) {
    SCOPED_TRACE(commands[i]->path);
    std::vector<std::string> names = OptionNames(*commands[i]);
    if (commands[i]->name() == "bench") {
      EXPECT_THAT(names, IsSupersetOf({"--editors", "--interval", "--json"}));
    }
    EXPECT_THAT(offers[i], UnorderedElementsAreArray(names));
  }
}

TEST_F(LatticectlReference, BashOffersCommandsWordsAndFiles) {
  ASSERT_OK(WriteFile(Path("my vase.obj"), ""));
  ASSERT_OK(WriteFile(Path("my.json"), ""));
  std::filesystem::create_directory(Path("my folder"));
  using Words = std::vector<std::string>;
  const std::vector<std::pair<Words, Words>> cases{
      {{"latticectl", "s"}, {"sample", "scene", "share", "store"}},
      {{"latticectl", "scene", ""}, {"create", "list", "show", "delete"}},
      {{"latticectl", "scene", "create", "--norm"}, {"--normals", "--normal-bits"}},
      {{"latticectl", "scene", "create", "--normals", ""}, {"facet", "smooth", "none"}},
      {{"latticectl", "scene", "create", "--normals", "="}, {"facet", "smooth", "none"}},
      {{"latticectl", "scene", "create", "--normals", "=", "s"}, {"smooth"}},
      {{"latticectl", "scene", "create", "--segments", ""}, {}},
      {{"latticectl", "scene", "create", "my"}, {"my vase.obj", "my.json", "my folder"}},
      {{"latticectl", "apply", "my vase.obj", "--lattice", "my.j"}, {"my.json"}},
      {{"latticectl", "apply", "--tls-ca", "my.j"}, {"my.json"}},
      {{"latticectl", "bench", "knot", "my v"}, {"my vase.obj"}},
      {{"latticectl", "quickstart", "--output", "my"}, {"my folder"}},
      {{"latticectl", "store", ""}, {"check"}},
      {{"latticectl", "store", "check", "my"}, {"my folder"}},
      {{"latticectl", "edit", "insert-knot", "my-scene", ""}, {"u", "v", "w"}},
      {{"latticectl", "edit", "insert-knot", "my"}, {}},  // a scene, which only the server knows
      {{"latticectl", "edit", "insert-knot", "--editor", "me", "my-scene", "v"}, {"v"}},
      {{"latticectl", "edit", "insert-knot", "--editor", "=", "me", "my-scene", "w"}, {"w"}},
      {{"latticectl", "sample", "--resolution", "3", "b"}, {"beam"}},
      {{"latticectl", "upload", "--name", "scene", "my.j"}, {"my.json"}},
      {{"latticectl", "fly", ""}, {}},
  };
  std::vector<Words> lines;
  for (const auto& [words, offered] : cases) lines.push_back(words);

  const auto offers = Completed(lines);

  for (size_t i = 0; i < cases.size(); ++i) {
    EXPECT_THAT(offers[i], UnorderedElementsAreArray(cases[i].second))
        << absl::StrJoin(cases[i].first, " ");
  }
}

TEST_F(LatticectlReference, ZshAndFishHaveEveryOptionOfEveryCommand) {
  const CommandEntry program = DeclaredCommands();
  const std::string zsh = MustRun({"completion", "zsh"}), fish = MustRun({"completion", "fish"});

  EXPECT_THAT(zsh, StartsWith("#compdef latticectl\n"));
  for (const CommandEntry* command : AllCommands(program)) {
    SCOPED_TRACE(command->path);
    std::string function = "_" + command->path + "() {\n";
    std::ranges::replace_if(
        function.begin(), function.end() - 4, [](char c) { return c == ' ' || c == '-'; }, '_');
    const size_t at = zsh.find(function);
    ASSERT_NE(at, std::string::npos) << function;
    const std::string body = zsh.substr(at, zsh.find("\n}\n", at) - at);
    for (const std::string& name : OptionNames(*command)) {
      const bool is_long = name.starts_with("--");
      EXPECT_THAT(body, ContainsRegex(fmt::format("'[(*][^\n]*{}=?\\[", name)));
      EXPECT_THAT(fish,
                  ContainsRegex(fmt::format("= \"{}\"'[^\n]* -{} {} ", command->path,
                                            is_long ? "l" : "s", name.substr(is_long ? 2 : 1))));
    }
  }
}

TEST_F(LatticectlReference, TheManualPageHasEveryOptionOfEveryCommand) {
  const CommandEntry program = DeclaredCommands();
  std::string page = MustRun({"man"});
  page.erase(std::remove(page.begin(), page.end(), '\\'), page.end());

  EXPECT_THAT(page, StartsWith(".TH LATTICECTL 1 "));
  for (const CommandEntry* command : AllCommands(program)) {
    SCOPED_TRACE(command->path);
    const std::string head =
        command == &program ? ".SH OPTIONS\n" : ".SS " + command->path.substr(11) + "\n";
    const size_t at = page.find(head);
    ASSERT_NE(at, std::string::npos);
    const std::string section = page.substr(at, page.find("\n.S", at + 1) - at);
    for (const std::string& name : OptionNames(*command)) {
      EXPECT_THAT(section, HasSubstr("fB" + name + "fR"));
    }
  }
  EXPECT_THAT(page, HasSubstr("Default: fB4,4,4fR."));
  EXPECT_THAT(page, HasSubstr("Environment: fBLATTICED_SERVERfR."));
  EXPECT_THAT(page, HasSubstr("Value: INT in [1 - 32]."));
  EXPECT_THAT(page, HasSubstr("fBfacet|smooth|nonefR"));
}

TEST_F(LatticectlReference, GroffTakesTheManualPageWithoutAWarning) {
  if (std::system("command -v groff >/dev/null") != 0) GTEST_SKIP() << "groff is not installed";
  ASSERT_OK(WriteFile(Path("latticectl.1"), MustRun({"man"})));

  EXPECT_EQ(Output(fmt::format("groff -man -ww -z '{}'", Path("latticectl.1"))), "");
  const std::string text =
      Output(fmt::format("groff -man -Tascii -P-cbou '{}'", Path("latticectl.1")));
  EXPECT_THAT(text, HasSubstr("latticectl apply [OPTIONS] mesh"));
  EXPECT_THAT(text, HasSubstr("Example: latticectl sample vase -o vase.obj\n"));
}

TEST_F(LatticectlReference, HelpCallsAFileAFile) {
  EXPECT_THAT(MustRun({"apply", "--help"}), HasSubstr("--lattice FILE ... REQUIRED"));
  EXPECT_THAT(MustRun({"quickstart", "--help"}), HasSubstr("--output FOLDER REQUIRED"));
  EXPECT_EQ(Latticectl({"completion", "tcsh"}).code, 2);
}

}  // namespace
}  // namespace latticed::client
