// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A connection that begins calls and never sends the last byte of their messages, or nothing at all, or
// sends all and takes no byte of a reply, or sends headers as it likes: HTTP/2 by hand, since no gRPC
// client does that. It keeps to the server's windows.
//
// Threads  one
#ifndef LATTICED_TESTS_SERVER_UNFINISHED_CALLS_H_
#define LATTICED_TESTS_SERVER_UNFINISHED_CALLS_H_

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
  // Whether it says that it has the server's settings, which limit its calls.
  enum class Settings { kAcknowledged, kIgnored };
  // `count` calls of `method` ("/package.Service/Method"), each with a message of `bytes`, which Run
  // sends. Fails the test where `address` (IPv4:port) does not answer.
  UnfinishedCalls(const std::string& address, std::string_view method, int count, size_t bytes,
                  Settings settings = Settings::kAcknowledged);
  // Calls of `method` with that request, as bytes, each begun by Begin; its window for replies is 0.
  UnfinishedCalls(const std::string& address, std::string_view method, std::string_view request);
  ~UnfinishedCalls();
  UnfinishedCalls(const UnfinishedCalls&) = delete;
  UnfinishedCalls& operator=(const UnfinishedCalls&) = delete;

  // One call more.
  void Begin();
  // One call more whose header has that block (RFC 7541) behind its own, in frames of so many bytes, and
  // ends or not.
  void BeginWith(std::string_view block, size_t frame_bytes, bool ends);
  // One call more: that is what comes of the frame of its header, which would have so many bytes.
  void BeginPartOfFrame(std::string_view block, size_t frame_bytes);
  // Of one frame, half of which comes a moment later.
  void BeginInPieces(std::string_view block);
  // A header of no call, in one frame: its number is no client's.
  void SendHeaderOfNoCall(std::string_view block);
  // Whether the server has taken all that was sent, and says so.
  bool AnswersPing();
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
  // What the server said: its SETTINGS_MAX_CONCURRENT_STREAMS and SETTINGS_MAX_FRAME_SIZE, and the
  // codes that it reset calls with.
  uint32_t max_calls() const { return max_calls_; }
  uint32_t max_frame() const { return max_frame_; }
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
  UnfinishedCalls(const std::string& address, std::string_view method, Message message,
                  Settings settings);
  // The number of one call more.
  uint32_t AddCall();
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
  const Settings settings_;
  int socket_ = -1;
  bool closed_ = false;
  // Between frames of one nothing may be sent (RFC 9113, 6.10): the server would close for that.
  bool in_header_ = false;
  std::string heard_;  // not taken yet
  int64_t window_ = 0, stream_window_ = 0;
  std::map<uint32_t, Call> calls_;
  uint32_t max_calls_ = 0, max_frame_ = 0;
  int pings_ = 0, answers_ = 0;
  std::set<uint32_t> reset_codes_;
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_UNFINISHED_CALLS_H_
