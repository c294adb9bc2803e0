// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The file of a backup: what BackupService.Backup streams, and how a cut or changed file is known.
//
//   "latticed backup 1\n" | size of a part, 32 bits, little-endian | the part, a BackupPart | size | part | … | end of file
//
// The last part is the end, with the number of parts before it and the SHA-256 of all bytes before its size.
//
// Errors   kUnknown, kNotFound: the file cannot be written, read; kDataLoss: it is no backup, or not whole
// Threads  one at a time
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_BACKUP_BACKUP_FILE_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_BACKUP_BACKUP_FILE_H_

#include <cstdint>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/sha256.h"
#include "latticed/v1/backup.pb.h"

namespace latticed::client {

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using FilePtr = std::unique_ptr<std::FILE, CloseFile>;

// What a backup has.
struct BackupContents {
  uint64_t meshes = 0, scenes = 0;
  uint64_t bytes = 0;                // of the file
  std::vector<std::string> damaged;  // a sentence each

  void Count(const v1::BackupPart& part);
};

class BackupWriter {
 public:
  // Writes path.part, which Commit renames. "-" is the standard output.
  explicit BackupWriter(std::string path) : path_(std::move(path)) {}
  // What was not committed is removed.
  ~BackupWriter();
  BackupWriter(const BackupWriter&) = delete;  // it owns the file
  BackupWriter& operator=(const BackupWriter&) = delete;

  // Begins, or begins anew, which standard output cannot.
  [[nodiscard]] absl::Status Begin();
  [[nodiscard]] absl::Status Add(const v1::BackupPart& part);
  // The bytes are on the disk, and the file has its name.
  [[nodiscard]] absl::Status Commit();
  const BackupContents& contents() const { return contents_; }

 private:
  bool is_stdout() const { return path_ == "-"; }
  std::string part_path() const { return path_ + ".part"; }
  [[nodiscard]] absl::Status Write(std::string_view bytes);
  [[nodiscard]] absl::Status Failed() const;

  const std::string path_;
  FilePtr file_;
  bool begun_ = false;
  std::optional<Sha256> sum_;
  BackupContents contents_;
};

class BackupReader {
 public:
  // Reads all of the file, and checks it. "-" is the standard input, which is copied to a temporary file first.
  [[nodiscard]] static absl::StatusOr<BackupReader> Open(const std::string& path);

  const BackupContents& contents() const { return contents_; }
  // The next part, nullopt after the end.
  [[nodiscard]] absl::StatusOr<std::optional<v1::BackupPart>> Next();
  // Bytes read by Next.
  uint64_t position() const { return position_; }

 private:
  explicit BackupReader(std::string name, FilePtr file)
      : name_(std::move(name)), file_(std::move(file)) {}

  [[nodiscard]] absl::Status Check();
  // The next part's bytes. Nullopt at the end of the file.
  [[nodiscard]] absl::StatusOr<std::optional<std::string>> ReadPart();
  [[nodiscard]] absl::Status ReadMagic();
  [[nodiscard]] absl::Status Damaged(std::string_view what) const;

  std::string name_;
  FilePtr file_;
  uint64_t position_ = 0;
  BackupContents contents_;
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_BACKUP_BACKUP_FILE_H_
