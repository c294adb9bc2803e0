// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/web/static_files.h"

#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <optional>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_split.h"
#include "fmt/format.h"
#include "server/web/content_coding.h"
#include "server/web/http_answers.h"

namespace latticed::web {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kPieceBytes = uint64_t{64} << 10;

// The build names the files of this folder after a hash of their content, so they never change.
constexpr std::string_view kHashedFolder = "assets";
constexpr char kNeverChanges[] = "public, max-age=31536000, immutable";
constexpr char kAskAgain[] = "no-cache";

constexpr std::array<std::pair<std::string_view, std::string_view>, 17> kMediaTypes = {
    {{".html", "text/html; charset=utf-8"},
     {".js", "text/javascript; charset=utf-8"},
     {".mjs", "text/javascript; charset=utf-8"},
     {".css", "text/css; charset=utf-8"},
     {".json", "application/json"},
     {".map", "application/json"},
     {".webmanifest", "application/manifest+json"},
     {".wasm", "application/wasm"},
     {".svg", "image/svg+xml"},
     {".png", "image/png"},
     {".jpg", "image/jpeg"},
     {".webp", "image/webp"},
     {".ico", "image/x-icon"},
     {".woff2", "font/woff2"},
     {".glb", "model/gltf-binary"},
     {".txt", "text/plain; charset=utf-8"},
     {".md", "text/plain; charset=utf-8"}}};

constexpr char kContentSecurityPolicy[] =
    "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self' blob:; "
    "connect-src 'self' blob:; img-src 'self' data: blob:; style-src 'self' 'unsafe-inline'";

constexpr char kNoViewer[] =
    "<!doctype html><title>latticed</title><h1>latticed is running, without its viewer</h1>"
    "<p>The server found no viewer beside its executable. Build the target <code>latticed_web"
    "</code>, which needs npm, or name its folder with <code>--web-root</code>. gRPC, gRPC-Web and "
    "WebSockets are served all the same.";

std::string_view MediaType(const fs::path& file) {
  const std::string extension = file.extension().string();
  for (const auto& [known, type] : kMediaTypes) {
    if (known == extension) return type;
  }
  return "application/octet-stream";
}

// The path below the root; nullopt if it would lead out of the root or to a hidden file.
std::optional<fs::path> Relative(std::string_view target) {
  std::string decoded;
  if (!PercentDecode(target, &decoded)) return std::nullopt;
  fs::path result;
  for (const auto piece : absl::StrSplit(decoded, '/', absl::SkipEmpty())) {
    const std::string name(piece);
    if (name.front() == '.' || name.find('\\') != std::string::npos) return std::nullopt;
    result /= name;
  }
  return decoded.ends_with('/') ? result / "index.html" : result;
}

bool IsBelow(const fs::path& file, const fs::path& root) {
  return std::mismatch(root.begin(), root.end(), file.begin(), file.end()).first == root.end();
}

bool Matches(std::string_view if_none_match, const std::string& etag) {
  for (const auto piece : absl::StrSplit(std::string(if_none_match), ',')) {
    std::string known(absl::StripAsciiWhitespace(piece));
    if (known.starts_with("W/")) known = known.substr(2);
    if (known == etag || known == "*") return true;
  }
  return false;
}

// A regular file below the root.
struct FoundFile {
  fs::path path;
  std::string etag;
  uint64_t bytes = 0;
};

std::optional<FoundFile> Find(const fs::path& path, const fs::path& root) {
  std::error_code failure;
  const fs::path file = fs::canonical(path, failure);
  struct stat facts = {};
  if (failure || !IsBelow(file, root) || stat(file.c_str(), &facts) != 0 ||
      !S_ISREG(facts.st_mode)) {
    return std::nullopt;
  }
  return FoundFile{
      file,
      fmt::format("\"{:x}-{:x}-{:x}\"", facts.st_size, facts.st_mtim.tv_sec, facts.st_mtim.tv_nsec),
      static_cast<uint64_t>(facts.st_size)};
}

HttpFields PageFields() {
  return {{"x-content-type-options", "nosniff"},
          {"content-security-policy", kContentSecurityPolicy},
          {"x-frame-options", "SAMEORIGIN"},  // no other site may show it in a frame
          {"referrer-policy", "same-origin"}};
}

// Sends the last `left` bytes of a file, one piece at a time.
void SendFile(const std::shared_ptr<HttpExchange>& exchange,
              const std::shared_ptr<std::ifstream>& file, uint64_t left) {
  if (left == 0) return exchange->End();
  std::string piece(std::min<uint64_t>(left, kPieceBytes), '\0');
  // The file may have become shorter meanwhile.
  if (!file->read(piece.data(), static_cast<std::streamsize>(piece.size()))) {
    return exchange->Abort();
  }
  left -= piece.size();
  exchange->Write({grpc::Slice(piece)}, [exchange, file, left] { SendFile(exchange, file, left); });
}

}  // namespace

StaticFiles::StaticFiles(fs::path root) : root_(std::move(root)) {}

fs::path StaticFiles::FindRoot(const std::string& web_root) {
  std::error_code failure;
  if (!web_root.empty()) return fs::weakly_canonical(web_root, failure);
  const fs::path folder = fs::read_symlink("/proc/self/exe", failure).parent_path();
  const fs::path beside = folder / "viewer";
  if (fs::exists(beside / "index.html", failure)) return fs::weakly_canonical(beside, failure);
  return fs::weakly_canonical(folder / "../share/latticed/viewer", failure);
}

void StaticFiles::Answer(const std::shared_ptr<HttpExchange>& exchange) const {
  const HttpRequest& request = exchange->request();
  if (request.method != "GET" && request.method != "HEAD") {
    return exchange->Reply(MethodNotAllowed("GET, HEAD"));
  }
  std::error_code failure;
  if (!fs::exists(root_ / "index.html", failure)) {
    HttpResponse answer{.status = 404, .fields = PageFields(), .body = kNoViewer};
    answer.fields.push_back({"cache-control", kAskAgain});
    answer.fields.push_back({"content-type", "text/html; charset=utf-8"});
    return exchange->Reply(std::move(answer));
  }
  const std::optional<fs::path> relative = Relative(request.path);
  std::optional<FoundFile> file = relative ? Find(root_ / *relative, root_) : std::nullopt;
  if (!file) return exchange->Reply(TextAnswer(404, "there is no such file"));
  HttpFields about = {{"content-type", std::string(MediaType(file->path))}};
  for (const ContentCoding& coding : AcceptedCodings(request.Field("accept-encoding"))) {
    auto copy = Find(file->path.string().append(coding.suffix), root_);
    if (!copy) continue;
    about.push_back({"content-encoding", std::string(coding.name)});
    file = std::move(copy);
    break;
  }
  HttpFields fields = PageFields();
  fields.push_back(
      {"cache-control", *relative->begin() == kHashedFolder ? kNeverChanges : kAskAgain});
  fields.push_back({"vary", "accept-encoding"});
  fields.push_back({"etag", file->etag});
  if (Matches(request.Field("if-none-match"), file->etag)) {
    return exchange->Reply({.status = 304, .fields = std::move(fields)});
  }
  Append(about, fields);
  exchange->Start(200, std::move(fields), file->bytes);
  SendFile(exchange, std::make_shared<std::ifstream>(file->path, std::ios::binary), file->bytes);
}

}  // namespace latticed::web
