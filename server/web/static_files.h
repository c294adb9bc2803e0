// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The viewer: files of one folder, index.html for "/". Browsers ask again with the ETag, so that a new release shows
// at once and an unchanged file is not sent again. They keep the files in assets/, whose names have a hash of the
// content. A client that accepts a compressed copy (server/web/content_coding.h) gets that copy.
//
// Errors   404 for a file that is not there or not below the folder; 405 for other methods than GET
//          and HEAD
// Memory   64 KiB for each answer, however large the file
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
