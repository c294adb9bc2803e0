// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/load/load_editor.h"

#include <utility>

#include "client/cpp/load/closed_loop_editor.h"
#include "client/cpp/load/periodic_editor.h"

namespace latticed::client {

absl::StatusOr<std::unique_ptr<LoadEditor>> OpenLoadEditor(std::unique_ptr<Client> client,
                                                           v1::WatchRequest request,
                                                           const LoadEditor::Context& context) {
  if (context.plan->mode == LoadMode::kClosed) {
    return ClosedLoopEditor::Open(std::move(client), std::move(request), context);
  }
  return PeriodicEditor::Open(std::move(client), std::move(request), context);
}

}  // namespace latticed::client
