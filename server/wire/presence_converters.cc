// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/wire/presence_converters.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/base/limits.h"
#include "fmt/format.h"

namespace latticed {
namespace {

// Counts code points. The text is valid UTF-8, as every string of a parsed message is.
size_t CharactersOf(const std::string& text) {
  return static_cast<size_t>(std::ranges::count_if(
      text, [](char byte) { return (static_cast<unsigned char>(byte) & 0xC0U) != 0x80U; }));
}

}  // namespace

absl::StatusOr<Presence> FromProto(const v1::Presence& message) {
  if (const size_t characters = CharactersOf(message.name());
      characters > limits::kMaxPresenceName) {
    return error::InvalidField("presence.name",
                               fmt::format("has {} characters, at most {} are allowed", characters,
                                           limits::kMaxPresenceName),
                               "OUT_OF_RANGE");
  }
  if (message.colour() > limits::kMaxPresenceColour) {
    return error::OutOfRange("presence.colour", message.colour(), 0, limits::kMaxPresenceColour);
  }
  const auto& indices = message.selected_indices();
  if (static_cast<size_t>(indices.size()) > limits::kMaxPresenceIndices) {
    return error::OutOfRange("presence.selected_indices", indices.size(), 0,
                             static_cast<double>(limits::kMaxPresenceIndices));
  }
  for (int i = 0; i < indices.size(); ++i) {
    if (indices[i] < static_cast<uint32_t>(limits::kMaxControlPoints)) continue;
    return error::OutOfRange(fmt::format("presence.selected_indices[{}]", i), indices[i], 0,
                             limits::kMaxControlPoints - 1);
  }
  if (message.left()) return error::InvalidField("presence.left", "is set only by the server");
  return Presence{.editor_id = message.editor_id(),
                  .name = message.name(),
                  .colour = message.colour(),
                  .selected = {indices.begin(), indices.end()}};
}

v1::Presence ToProto(const Presence& presence) {
  v1::Presence message;
  message.set_editor_id(presence.editor_id);
  message.set_name(presence.name);
  message.set_colour(presence.colour);
  message.mutable_selected_indices()->Add(presence.selected.begin(), presence.selected.end());
  message.set_left(presence.left);
  return message;
}

}  // namespace latticed
