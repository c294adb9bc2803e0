// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The viewer: files of one folder, index.html for "/". Each is asked for again with its ETag, so that
// a new release shows at once and an old one costs no transfer.
//
// Errors   404 for what is not there, whatever ".." or links say; 405 but for GET and HEAD
// Memory   64 KiB an answer that is under way, however large the file
// Threads  safe; reads files on the connection's strand
#ifndef LATTICED_SERVER_WEB_STATIC_FILES_H_
#define LATTICED_SERVER_WEB_STATIC_FILES_H_

#include <filesystem>
#include <memory>
#include <string>

#include "server/web/http_exchange.h"

namespace latticed::web {

class StaticFiles {
 public:
  explicit StaticFiles(std::filesystem::path root);
  // `web_root`, or where that is empty beside the executable: viewer/, ../share/latticed/viewer/.
  [[nodiscard]] static std::filesystem::path FindRoot(const std::string& web_root);

  void Answer(const std::shared_ptr<HttpExchange>& exchange) const;

 private:
  const std::filesystem::path root_;  // without links
};

}  // namespace latticed::web

#endif  // LATTICED_SERVER_WEB_STATIC_FILES_H_
