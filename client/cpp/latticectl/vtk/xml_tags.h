// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The tags of an XML file of VTK, up to its appended data, which are not XML. A file's text is passed on as it is, so
// tags are places in it.
//
// Errors   kInvalidArgument in one sentence, without the file's name
// Threads  pure functions
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_VTK_XML_TAGS_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_VTK_XML_TAGS_H_

#include <cstddef>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace latticed::client {

struct XmlTag {
  size_t begin = 0, end = 0;    // of <…>
  std::string_view name;        // "Points", "/Points"
  std::string_view attributes;  // between name and end
  bool is_empty = false;        // <…/>

  // The value of an attribute; empty without it.
  [[nodiscard]] std::string_view Value(std::string_view attribute) const;
};

// Tags in order, without comments and declarations. The last one is AppendedData, if there is any.
[[nodiscard]] absl::StatusOr<std::vector<XmlTag>> XmlTagsOf(std::string_view bytes);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_VTK_XML_TAGS_H_
