// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// GET /export/<scene>.<format>: SceneService.Export as a download, under the file name that the server
// gives it. Formats: ply, obj, stl, glb, drc, nets.
//
//   ?segments=20         1 to 32 segments an edge     } absent: as in the scene's default view
//   ?tolerance=0.01      in world units, above 0      }
//   ?normals=smooth      none, facet or smooth        }
//
// The field latticed-certified-error has ExportHeader.certified_error where there is one.
//
// Errors   an HTTP status with the words of the rpc's; a failure after the first byte breaks the
//          connection, so that no browser keeps half a file
// Threads  on the connection's strand
#ifndef LATTICED_SERVER_WEB_EXPORT_DOWNLOAD_H_
#define LATTICED_SERVER_WEB_EXPORT_DOWNLOAD_H_

#include <memory>
#include <string_view>

#include "server/web/generic_call.h"
#include "server/web/http_exchange.h"
#include "server/web/request_guard.h"

namespace latticed::web {

inline constexpr std::string_view kExportPrefix = "/export/";

// Answers a request to a path that begins with kExportPrefix. `guard` outlives the connections.
void RunExportDownload(const ServerChannel& server, const RequestGuard& guard,
                       const std::shared_ptr<HttpExchange>& exchange);

}  // namespace latticed::web

#endif  // LATTICED_SERVER_WEB_EXPORT_DOWNLOAD_H_
