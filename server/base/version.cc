// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/base/version.h"

namespace latticed {

std::string_view Version() { return LATTICED_VERSION; }
std::string_view Commit() { return LATTICED_COMMIT; }

}  // namespace latticed
