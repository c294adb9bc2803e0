// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A connection that begins calls and never sends the last byte of their messages, or nothing at all, or
// sends all and takes no byte of a reply: HTTP/2 by hand, since no gRPC client does that. It keeps to the
// server's windows.
//
// Threads  one
#ifndef LATTICED_TESTS_SERVER_SUPPORT_UNFINISHED_CALLS_H_
#define LATTICED_TESTS_SERVER_SUPPORT_UNFINISHED_CALLS_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <string_view>

namespace latticed::testing {

class UnfinishedCalls {
 public:
  // `count` calls of `method` ("/package.Service/Method"), each with a message of `bytes`, which Run
  // sends. Fails the test where `address` (IPv4:port) does not answer.
  UnfinishedCalls(const std::string& address, std::string_view method, int count, size_t bytes);
  // Calls of `method` with that request, as bytes, each begun by Begin; its window for replies is 0.
  UnfinishedCalls(const std::string& address, std::string_view method, std::string_view request);
  ~UnfinishedCalls();
  UnfinishedCalls(const UnfinishedCalls&) = delete;
  UnfinishedCalls& operator=(const UnfinishedCalls&) = delete;

  // One call more.
  void Begin();
  // Sends what the server's windows allow and hears what it says until `done`. False when that
  // takes a minute, or the server closes the connection.
  bool Run(const std::function<bool()>& done);

  // Of messages, of calls that the server has not ended.
  size_t held_bytes() const;
  // Calls that the server has ended, those of which all is sent that will be, and those whose reply has
  // begun: its headers, which need no window.
  size_t ended() const;
  size_t sent() const;
  size_t answered() const;
  // The server's SETTINGS_MAX_CONCURRENT_STREAMS, and the codes that it reset calls with.
  uint32_t max_calls() const { return max_calls_; }
  const std::set<uint32_t>& reset_codes() const { return reset_codes_; }

 private:
  struct Call {
    int64_t window = 0;
    size_t sent = 0;  // of the message
    bool answered = false;
    bool ended = false;
  };
  // With the header of its message.
  struct Message {
    std::string bytes;
    size_t sent = 0;  // of these, at most
  };
  UnfinishedCalls(const std::string& address, std::string_view method, Message message);
  void SendFrame(uint8_t type, uint8_t flags, uint32_t stream, std::string_view payload);
  void SendBytes(std::string_view bytes);
  // Whatever the windows allow.
  void SendData();
  // Waits for some milliseconds where nothing is there.
  void Hear();
  void Take(uint8_t type, uint8_t flags, uint32_t stream, std::string_view payload);
  void TakeSettings(std::string_view payload);

  const std::string method_;
  const Message message_;
  int socket_ = -1;
  bool closed_ = false;
  std::string heard_;  // not taken yet
  int64_t window_ = 0, stream_window_ = 0;
  std::map<uint32_t, Call> calls_;
  uint32_t max_calls_ = 0;
  std::set<uint32_t> reset_codes_;
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_SUPPORT_UNFINISHED_CALLS_H_
