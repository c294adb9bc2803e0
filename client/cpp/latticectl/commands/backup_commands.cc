// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "client/cpp/latticectl/backup/backup_file.h"
#include "client/cpp/latticectl/command_line/value_types.h"
#include "client/cpp/latticectl/commands/commands.h"
#include "client/cpp/latticectl/output/output.h"
#include "client/cpp/latticectl/session/session.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

struct BackupFlags : ServerFlags {
  std::string file;
  std::vector<std::string> scenes;
  bool skip_existing = false;
};

// The bytes of all meshes: most of a backup.
uint64_t BytesOfMeshes(Client& client) {
  uint64_t bytes = 0;
  if (const auto meshes = client.ListMeshes(); meshes.ok()) {
    for (const v1::Mesh& mesh : *meshes) bytes += mesh.total_bytes();
  }
  return bytes;
}

absl::Status RunBackup(const BackupFlags& flags, Client& client, Console console) {
  v1::BackupRequest request;
  request.mutable_scenes()->Add(flags.scenes.begin(), flags.scenes.end());
  BackupWriter writer(flags.file);
  {
    const uint64_t expected = console.err_is_terminal ? BytesOfMeshes(client) : 0;
    ProgressBar bar(console, "backup", ProgressBar::Unit::kBytes);
    LATTICED_RETURN_IF_ERROR(client.Backup(
        request, [&] { return writer.Begin(); },
        [&](const v1::BackupPart& part) {
          LATTICED_RETURN_IF_ERROR(writer.Add(part));
          bar.Show(writer.contents().bytes, std::max(expected, writer.contents().bytes));
          return absl::OkStatus();
        }));
    LATTICED_RETURN_IF_ERROR(writer.Commit());
  }
  const BackupContents& contents = writer.contents();
  const bool to_stdout = flags.file == "-";
  PrintResult(
      flags.json,
      nlohmann::json{{"output", flags.file},
                     {"meshes", contents.meshes},
                     {"scenes", contents.scenes},
                     {"bytes", contents.bytes},
                     {"damaged", contents.damaged}},
      fmt::format("{}: {}, {}, {}\n", flags.file, Counted(contents.meshes, "mesh", "meshes"),
                  Counted(contents.scenes, "scene"), FormatBytes(contents.bytes)),
      to_stdout ? console.err : console.out);
  if (contents.damaged.empty()) return absl::OkStatus();
  std::string all = fmt::format("{} on the server are damaged, and left out:",
                                Counted(contents.damaged.size(), "thing"));
  for (const std::string& what : contents.damaged) all += "\n  " + what;
  return absl::DataLossError(all);
}

absl::Status RunRestore(const BackupFlags& flags, Client& client, Console console) {
  LATTICED_ASSIGN_OR_RETURN(BackupReader reader, BackupReader::Open(flags.file));
  v1::RestoreOptions options;
  options.set_skip_existing(flags.skip_existing);
  absl::StatusOr<v1::RestoreResponse> done;
  {
    ProgressBar bar(console, "restore", ProgressBar::Unit::kBytes);
    done = client.Restore(options, [&] {
      bar.Show(reader.position(), reader.contents().bytes);
      return reader.Next();
    });
  }
  if (absl::IsAlreadyExists(done.status()) && !flags.skip_existing) {
    return absl::Status(done.status().code(),
                        fmt::format("{}; --skip-existing passes over scenes that are there",
                                    std::string(done.status().message())));
  }
  LATTICED_RETURN_IF_ERROR(done.status());
  std::string text = fmt::format("restored {} and {}", Counted(done->meshes(), "mesh", "meshes"),
                                 Counted(done->scenes(), "scene"));
  if (done->present_meshes() + done->skipped_scenes() > 0) {
    text += fmt::format("; {} and {} were there", Counted(done->present_meshes(), "mesh", "meshes"),
                        Counted(done->skipped_scenes(), "scene"));
  }
  if (done->damaged() > 0) {
    text +=
        fmt::format("; {} were damaged when the backup was made", Counted(done->damaged(), "item"));
  }
  PrintResult(flags.json, *done, text + "\n", console.out);
  return absl::OkStatus();
}

}  // namespace

void AddBackupCommands(CLI::App& app, CommandLine& line) {
  auto backup_flags = std::make_shared<BackupFlags>();
  CLI::App* backup = app.add_subcommand(
      "backup", "Copies meshes and scenes of a running server, with their undo steps, to a file");
  backup->add_option("file", backup_flags->file, "File to write; - is the standard output")
      ->required()
      ->type_name(kFileType);
  backup->add_option("--scene", backup_flags->scenes,
                     "Only this scene and its mesh; may be repeated");
  SetExample(*backup, "backup today.backup --server studio:50151");
  SetServerAction(*backup, backup_flags, line, RunBackup);

  auto restore_flags = std::make_shared<BackupFlags>();
  CLI::App* restore =
      app.add_subcommand("restore", "Makes the meshes and scenes of a backup on a running server");
  restore->add_option("file", restore_flags->file, "File of a backup; - is the standard input")
      ->required()
      ->type_name(kFileType);
  restore->add_flag("--skip-existing", restore_flags->skip_existing,
                    "Pass over scenes that are there; by default they end the restore");
  SetExample(*restore, "restore today.backup --server studio:50151");
  SetServerAction(*restore, restore_flags, line, RunRestore);
}

}  // namespace latticed::client
