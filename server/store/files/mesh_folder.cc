// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/store/files/mesh_folder.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <set>
#include <system_error>
#include <utility>

#include "core/base/read_file.h"
#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/base/auth/tenant.h"
#include "server/base/telemetry.h"
#include "server/store/objects/mesh_names.h"
#include "server/store/store_errors.h"

namespace latticed {
namespace {

constexpr std::string_view kNewPrefix = "new-";

// Clients are not told where the file is.
absl::Status FileFailed(const std::string& path) {
  const int why = errno;
  LogEvent(spdlog::level::err, "the file of a mesh failed",
           {{"file", path}, {"error", std::strerror(why)}});
  const std::string problem =
      fmt::format("{}: {}", std::filesystem::path(path).filename().string(), std::strerror(why));
  const bool full = why == ENOSPC || why == EDQUOT || why == EFBIG;
  return full ? error::StoreFull(problem) : error::StoreFailed(problem);
}

// A file descriptor that is closed when it goes.
class OpenFile {
 public:
  OpenFile(const std::string& path, int flags)
      : file_(open(path.c_str(), flags | O_CLOEXEC, S_IRUSR | S_IWUSR)) {}
  ~OpenFile() {
    if (file_ >= 0) close(file_);
  }
  OpenFile(const OpenFile&) = delete;  // one close for one open
  OpenFile& operator=(const OpenFile&) = delete;

  bool ok() const { return file_ >= 0; }
  int get() const { return file_; }

 private:
  const int file_;
};

bool WriteAll(int file, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(file, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return false;
    bytes.remove_prefix(static_cast<size_t>(written));
  }
  return true;
}

// Whether nobody has written the file for so long.
bool IsOlder(const std::filesystem::directory_entry& entry, absl::Duration age) {
  std::error_code failure;
  const auto written = entry.last_write_time(failure);
  return !failure &&
         std::filesystem::file_time_type::clock::now() - written > absl::ToChronoSeconds(age);
}

}  // namespace

absl::Status MeshFolder::Open(const std::vector<std::string>& known, absl::Duration age) {
  std::error_code failure;
  std::filesystem::create_directories(path_, failure);
  if (failure) return error::StoreFailed(fmt::format("{}: {}", path_, failure.message()));
  std::set<std::string> missing;
  for (const std::string& id : known) missing.insert(MeshName(id));
  for (const auto& entry : std::filesystem::directory_iterator(path_, failure)) {
    const std::string name = entry.path().filename().string();
    if (missing.erase(name) > 0) continue;
    if (!IsMeshName(name) && !name.starts_with(kNewPrefix)) continue;
    if (age > absl::ZeroDuration() && !IsOlder(entry, age)) continue;
    LogEvent(spdlog::level::info, "removed a mesh file that a crash left", {{"file", name}});
    std::error_code ignored;
    std::filesystem::remove(entry.path(), ignored);
  }
  if (failure) return error::StoreFailed(fmt::format("{}: {}", path_, failure.message()));
  if (missing.empty()) return SyncFolder();
  return error::Damaged(fmt::format("mesh {}", *missing.begin()),
                        fmt::format("its file in {} is missing", path_));
}

std::string MeshFolder::PathOf(std::string_view id) const {
  return fmt::format("{}/{}", path_, MeshName(id));
}

absl::StatusOr<std::string> MeshFolder::Write(std::string_view /*id*/, std::string_view bytes) {
  std::string name = fmt::format("{}/{}{}{}", path_, kNewPrefix, writer_, next_name_++);
  const OpenFile file(name, O_WRONLY | O_CREAT | O_TRUNC);
  if (!file.ok()) return FileFailed(name);
  if (WriteAll(file.get(), bytes) && fsync(file.get()) == 0) return name;
  const absl::Status status = FileFailed(name);
  Discard(name);
  return status;
}

absl::Status MeshFolder::Publish(const std::string& written, std::string_view id,
                                 std::string_view /*bytes*/) {
  const std::string path = PathOf(id);
  if (rename(written.c_str(), path.c_str()) != 0) {
    const int why = errno;
    const bool published_before = why == ENOENT && access(path.c_str(), F_OK) == 0;
    errno = why;
    if (!published_before) return FileFailed(written);
  }
  return SyncFolder();
}

void MeshFolder::Discard(const std::string& written) { unlink(written.c_str()); }

absl::Status MeshFolder::Remove(std::string_view id) {
  const std::string path = PathOf(id);
  if (unlink(path.c_str()) != 0 && errno != ENOENT) return FileFailed(path);
  return SyncFolder();
}

absl::StatusOr<std::string> MeshFolder::Read(std::string_view id) const {
  absl::StatusOr<std::string> bytes = ReadFile(PathOf(id));
  const std::string name = fmt::format("mesh {}", id);
  if (!bytes.ok()) {
    LogEvent(spdlog::level::err, "the file of a mesh failed",
             {{"error", std::string(bytes.status().message())}});
    return error::Damaged(name, "its file cannot be read");
  }
  if (Sha256Hex(*bytes) != IdOf(id)) return error::Damaged(name, "its bytes have another hash");
  return bytes;
}

absl::Status MeshFolder::SyncFolder() const {
  const OpenFile folder(path_, O_RDONLY | O_DIRECTORY);
  if (folder.ok() && fsync(folder.get()) == 0) return absl::OkStatus();
  return FileFailed(path_);
}

}  // namespace latticed
