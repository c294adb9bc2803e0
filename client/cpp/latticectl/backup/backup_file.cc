// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/backup/backup_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

constexpr std::string_view kMagic = "latticed backup 1\n";
constexpr std::string_view kAnyMagic = "latticed backup ";
constexpr uint64_t kMostPartBytes = uint64_t{1} << 20;
constexpr size_t kSizeBytes = 4;

std::string SizeOf(uint64_t bytes) {
  std::string size(kSizeBytes, '\0');
  for (size_t i = 0; i < kSizeBytes; ++i) size[i] = static_cast<char>(bytes >> (8 * i));
  return size;
}
uint64_t SizeFrom(const std::array<unsigned char, kSizeBytes>& size) {
  uint64_t bytes = 0;
  for (size_t i = 0; i < kSizeBytes; ++i) bytes |= uint64_t{size[i]} << (8 * i);
  return bytes;
}

// So that the file's new name survives a loss of power.
bool SyncFolderOf(const std::string& path) {
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  const int descriptor = open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY);
  if (descriptor < 0) return false;
  const bool synced = fsync(descriptor) == 0;
  close(descriptor);
  return synced;
}

absl::StatusOr<FilePtr> CopyOfStdin() {
  FilePtr copy(std::tmpfile());
  std::vector<char> block(kMostPartBytes);
  while (copy != nullptr) {
    const size_t read = std::fread(block.data(), 1, block.size(), stdin);
    if (read == 0) break;
    if (std::fwrite(block.data(), 1, read, copy.get()) != read) copy.reset();
  }
  if (copy == nullptr || std::ferror(stdin) != 0) {
    return absl::UnknownError(
        fmt::format("cannot keep the standard input in a temporary file: {}", strerror(errno)));
  }
  std::rewind(copy.get());
  return copy;
}

}  // namespace

void BackupContents::Count(const v1::BackupPart& part) {
  if (!part.has_item()) return;
  const v1::BackupItem& item = part.item();
  if (!item.damage().empty()) {
    damaged.push_back(fmt::format("{} {}: {}", item.has_mesh() ? "mesh" : "scene",
                                  item.has_mesh() ? item.mesh() : item.scene(), item.damage()));
  } else {
    ++(item.has_mesh() ? meshes : scenes);
  }
}

BackupWriter::~BackupWriter() {
  if (is_stdout()) {
    (void)file_.release();
  } else if (file_ != nullptr) {
    std::remove(part_path().c_str());
  }
}

absl::Status BackupWriter::Failed() const {
  return absl::UnknownError(fmt::format("cannot write {}: {}",
                                        is_stdout() ? "the standard output" : part_path(),
                                        std::strerror(errno)));
}

absl::Status BackupWriter::Begin() {
  if (begun_ && is_stdout()) {
    return absl::AbortedError("the connection broke, and the standard output cannot begin anew");
  }
  begun_ = true;
  file_.reset(is_stdout() ? stdout : std::fopen(part_path().c_str(), "wb"));
  if (file_ == nullptr) return Failed();
  sum_.emplace();
  contents_ = {};
  return Write(kMagic);
}

absl::Status BackupWriter::Write(std::string_view bytes) {
  sum_->Update(bytes);
  contents_.bytes += bytes.size();
  return std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) == bytes.size() ? absl::OkStatus()
                                                                                 : Failed();
}

absl::Status BackupWriter::Add(const v1::BackupPart& part) {
  contents_.Count(part);
  v1::BackupPart end;
  if (part.has_end()) {
    end = part;
    end.mutable_end()->set_sha256(sum_->FinishHex());
    sum_.emplace();
  }
  const std::string bytes = (part.has_end() ? end : part).SerializeAsString();
  LATTICED_RETURN_IF_ERROR(Write(SizeOf(bytes.size())));
  return Write(bytes);
}

absl::Status BackupWriter::Commit() {
  if (std::fflush(file_.get()) != 0) return Failed();
  if (is_stdout()) return absl::OkStatus();
  if (fsync(fileno(file_.get())) != 0) return Failed();
  if (std::rename(part_path().c_str(), path_.c_str()) != 0) return Failed();
  file_.reset();
  return SyncFolderOf(path_) ? absl::OkStatus() : Failed();
}

absl::StatusOr<BackupReader> BackupReader::Open(const std::string& path) {
  FilePtr file;
  if (path == "-") {
    LATTICED_ASSIGN_OR_RETURN(file, CopyOfStdin());
  } else {
    file.reset(std::fopen(path.c_str(), "rb"));
    if (file == nullptr) {
      return absl::NotFoundError(fmt::format("cannot read {}: {}", path, std::strerror(errno)));
    }
  }
  BackupReader reader(path == "-" ? "the standard input" : path, std::move(file));
  LATTICED_RETURN_IF_ERROR(reader.Check());
  std::rewind(reader.file_.get());
  reader.position_ = 0;
  LATTICED_RETURN_IF_ERROR(reader.ReadMagic());
  return reader;
}

absl::Status BackupReader::Damaged(std::string_view what) const {
  return absl::DataLossError(fmt::format("{}: {}; nothing was sent", name_, what));
}

absl::Status BackupReader::ReadMagic() {
  std::string magic(kMagic.size(), '\0');
  magic.resize(std::fread(magic.data(), 1, magic.size(), file_.get()));
  position_ += magic.size();
  if (magic == kMagic) return absl::OkStatus();
  if (!magic.starts_with(kAnyMagic)) return Damaged("is no backup of latticed");
  return Damaged("is a backup of another version, which this latticectl cannot read");
}

absl::StatusOr<std::optional<std::string>> BackupReader::ReadPart() {
  std::array<unsigned char, kSizeBytes> size{};
  const size_t read = std::fread(size.data(), 1, size.size(), file_.get());
  if (read == 0 && std::feof(file_.get()) != 0) return std::nullopt;
  if (read != size.size()) return Damaged("is cut off");
  if (SizeFrom(size) > kMostPartBytes) return Damaged("was changed since it was written");
  std::string part(SizeFrom(size), '\0');
  if (std::fread(part.data(), 1, part.size(), file_.get()) != part.size()) {
    return Damaged("is cut off");
  }
  position_ += size.size() + part.size();
  return part;
}

absl::StatusOr<std::optional<v1::BackupPart>> BackupReader::Next() {
  LATTICED_ASSIGN_OR_RETURN(const auto bytes, ReadPart());
  if (!bytes.has_value()) return std::optional<v1::BackupPart>();
  v1::BackupPart part;
  if (!part.ParseFromString(*bytes)) return Damaged("was changed since it was written");
  return std::optional(std::move(part));
}

absl::Status BackupReader::Check() {
  LATTICED_RETURN_IF_ERROR(ReadMagic());
  Sha256 sum;
  sum.Update(kMagic);
  v1::BackupPart part;
  for (uint64_t parts = 0; true; ++parts) {
    LATTICED_ASSIGN_OR_RETURN(const auto bytes, ReadPart());
    if (!bytes.has_value()) return Damaged("is cut off");
    if (!part.ParseFromString(*bytes)) return Damaged("was changed since it was written");
    contents_.Count(part);
    if (part.has_end()) {
      if (part.end().sha256() != sum.FinishHex() || part.end().parts() != parts) {
        return Damaged("was changed since it was written");
      }
      break;
    }
    sum.Update(SizeOf(bytes->size()));
    sum.Update(*bytes);
  }
  contents_.bytes = position_;
  if (std::fgetc(file_.get()) != EOF) return Damaged("has bytes after its end");
  return absl::OkStatus();
}

}  // namespace latticed::client
