// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/vtk/xml_tags.h"

#include <algorithm>

#include "absl/status/status.h"

namespace latticed::client {
namespace {

constexpr std::string_view kXmlSpace = " \t\r\n";

// Where the tag that begins at `begin` ends: behind a > that is not in quotes. npos: nowhere.
size_t EndOfTag(std::string_view bytes, size_t begin) {
  char quote = 0;
  for (size_t at = begin; at < bytes.size(); ++at) {
    const char c = bytes[at];
    if (quote != 0) {
      if (c == quote) quote = 0;
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (c == '>') {
      return at + 1;
    }
  }
  return std::string_view::npos;
}

XmlTag TagOf(std::string_view bytes, size_t begin, size_t end) {
  XmlTag tag{.begin = begin, .end = end};
  std::string_view inner = bytes.substr(begin + 1, end - begin - 2);
  tag.is_empty = inner.ends_with('/');
  if (tag.is_empty) inner.remove_suffix(1);
  const size_t name = std::min(inner.find_first_of(kXmlSpace), inner.size());
  tag.name = inner.substr(0, name);
  tag.attributes = inner.substr(name);
  return tag;
}

}  // namespace

std::string_view XmlTag::Value(std::string_view attribute) const {
  std::string_view rest = attributes;
  while (true) {
    const size_t begin = rest.find_first_not_of(kXmlSpace);
    const size_t equals = rest.find('=');
    if (begin == std::string_view::npos || equals == std::string_view::npos) return "";
    std::string_view key = rest.substr(begin, equals - begin);
    key = key.substr(0, key.find_last_not_of(kXmlSpace) + 1);
    const size_t open = rest.find_first_not_of(kXmlSpace, equals + 1);
    if (open == std::string_view::npos) return "";
    const size_t close = rest.find(rest[open], open + 1);
    if (close == std::string_view::npos) return "";
    if (key == attribute) return rest.substr(open + 1, close - open - 1);
    rest = rest.substr(close + 1);
  }
}

absl::StatusOr<std::vector<XmlTag>> XmlTagsOf(std::string_view bytes) {
  std::vector<XmlTag> tags;
  for (size_t at = bytes.find('<'); at != std::string_view::npos; at = bytes.find('<', at)) {
    const bool is_comment = bytes.substr(at).starts_with("<!--");
    const size_t dashes = is_comment ? bytes.find("-->", at + 4) : 0;
    const size_t end = !is_comment                        ? EndOfTag(bytes, at)
                       : dashes == std::string_view::npos ? dashes
                                                          : dashes + 3;
    if (end == std::string_view::npos) {
      return absl::InvalidArgumentError("has an XML tag that does not end");
    }
    if (bytes[at + 1] != '!' && bytes[at + 1] != '?') {
      tags.push_back(TagOf(bytes, at, end));
      if (tags.back().name == "AppendedData") break;
    }
    at = end;
  }
  if (tags.empty() || tags.front().name != "VTKFile") {
    return absl::InvalidArgumentError("is no XML file of VTK: it does not begin with VTKFile");
  }
  return tags;
}

}  // namespace latticed::client
