// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Presence on the client's side of a stream: what it shows, which a stream that opens again must
// show again, and who else is there.
//
// Errors   none
// Threads  one at a time
#ifndef LATTICED_CLIENT_CPP_LIBRARY_PRESENCE_H_
#define LATTICED_CLIENT_CPP_LIBRARY_PRESENCE_H_

#include <map>
#include <optional>
#include <string>
#include <utility>

#include "latticed/v1/event.pb.h"

namespace latticed::client {

// By editor_id.
using Others = std::map<std::string, v1::Presence>;

class PresenceState {
 public:
  void Show(v1::Presence presence) { shown_ = std::move(presence); }
  const std::optional<v1::Presence>& shown() const { return shown_; }

  // An rpc begins: its server tells of all who are there.
  void Begin() { others_.clear(); }
  void Take(const v1::Presence& presence) {
    if (presence.left()) {
      others_.erase(presence.editor_id());
    } else {
      others_[presence.editor_id()] = presence;
    }
  }
  const Others& others() const { return others_; }

 private:
  std::optional<v1::Presence> shown_;
  Others others_;
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LIBRARY_PRESENCE_H_
