// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A connection whose calls do not finish. It never sends the last byte of a message, or sends no message, or
// takes no byte of a reply. It speaks HTTP/2 itself, since no gRPC client does that, and obeys the server's
// flow-control windows.
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
  // Begins `count` calls of `method` ("/package.Service/Method"). Run sends all but the last of `bytes`
  // bytes of each message. Fails the test when `address` (IPv4:port) does not answer.
  UnfinishedCalls(const std::string& address, std::string_view method, int count, size_t bytes);
  // Each Begin calls `method` with the serialised `request`. The window for replies is 0 bytes.
  UnfinishedCalls(const std::string& address, std::string_view method, std::string_view request);
  ~UnfinishedCalls();
  UnfinishedCalls(const UnfinishedCalls&) = delete;
  UnfinishedCalls& operator=(const UnfinishedCalls&) = delete;

  // Begins one more call.
  void Begin();
  // Sends what the server's windows allow, and reads what the server sends, until `done`. False after
  // a minute, or when the server closes the connection.
  bool Run(const std::function<bool()>& done);

  // Message bytes sent in calls that the server has not ended.
  size_t held_bytes() const;
  // How many calls the server has ended; how many others have sent all that they will; and how many have
  // the headers of their reply, which need no window.
  size_t ended() const;
  size_t sent() const;
  size_t answered() const;
  // The server's SETTINGS_MAX_CONCURRENT_STREAMS, and the error codes with which it reset calls.
  uint32_t max_calls() const { return max_calls_; }
  const std::set<uint32_t>& reset_codes() const { return reset_codes_; }

 private:
  struct Call {
    int64_t window = 0;
    size_t sent = 0;  // bytes of the message
    bool answered = false;
    bool ended = false;
  };
  // A gRPC message with its header.
  struct Message {
    std::string bytes;
    size_t sent = 0;  // how many bytes are sent at most
  };
  UnfinishedCalls(const std::string& address, std::string_view method, Message message);
  void SendFrame(uint8_t type, uint8_t flags, uint32_t stream, std::string_view payload);
  void SendBytes(std::string_view bytes);
  // Sends what the windows allow.
  void SendData();
  // Reads what the server sent. Waits a few milliseconds when there is nothing.
  void Hear();
  void Take(uint8_t type, uint8_t flags, uint32_t stream, std::string_view payload);
  void TakeSettings(std::string_view payload);

  const std::string method_;
  const Message message_;
  int socket_ = -1;
  bool closed_ = false;
  std::string heard_;  // received, but not yet handled
  int64_t window_ = 0, stream_window_ = 0;
  std::map<uint32_t, Call> calls_;
  uint32_t max_calls_ = 0;
  std::set<uint32_t> reset_codes_;
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_SUPPORT_UNFINISHED_CALLS_H_
