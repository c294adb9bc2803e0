// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// An open WebSocket, as handlers see it: binary messages, one read and one write at a time.
//
// Threads  Post from anywhere; everything else, and every callback, on the connection's strand
#ifndef LATTICED_SERVER_WEB_WEB_SOCKET_H_
#define LATTICED_SERVER_WEB_WEB_SOCKET_H_

#include <cstdint>
#include <functional>
#include <string>

#include "server/web/out_bytes.h"

namespace latticed::web {

class WebSocket {
 public:
  enum class Event {
    kMessage,      // a whole binary message
    kTextMessage,  // of text: its content is not kept
    kClosed,       // the other side closed it in order
    kGone  // the connection broke, was silent for too long, or sent no valid WebSocket frame
  };

  virtual ~WebSocket() = default;
  virtual void Post(std::function<void()> work) = 0;
  // Calls `done` with the next event; `message` is empty but for kMessage. None comes after kClosed
  // or kGone. A message above limits::kMaxMessageBytes closes the socket with code 1009, kGone.
  virtual void Read(std::function<void(Event event, std::string message)> done) = 0;
  // Not called back when the connection breaks: Read or OnGone reports that.
  virtual void Write(OutBytes message, std::function<void()> done) = 0;
  // After the write that is under way. `reason` is cut to 123 bytes.
  virtual void Close(uint16_t code, const std::string& reason) = 0;
  // Called when the connection breaks while no Read is pending.
  virtual void OnGone(std::function<void()> gone) = 0;
};

}  // namespace latticed::web

#endif  // LATTICED_SERVER_WEB_WEB_SOCKET_H_
