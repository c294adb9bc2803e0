// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/edge/header_frames.h"

namespace latticed {

bool HeadersAreBounded() { return false; }

}  // namespace latticed
