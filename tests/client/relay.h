// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A TCP relay on a free loopback port: a network that becomes silent without a word, or is slow.
//
// Threads  any
#ifndef LATTICED_TESTS_CLIENT_RELAY_H_
#define LATTICED_TESTS_CLIENT_RELAY_H_

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <list>
#include <string>
#include <thread>
#include <vector>

#include "core/base/mutex.h"

namespace latticed::client {

class Relay {
 public:
  // To 127.0.0.1:port. bytes_per_second: of each direction; 0: as fast as it goes.
  explicit Relay(const std::string& address, double bytes_per_second = 0)
      : target_(Loopback(std::stoi(address.substr(address.rfind(':') + 1)))),
        rate_(bytes_per_second) {
    const sockaddr_in any_port = Loopback(0);
    bind(listener_, Generic(any_port), sizeof(any_port));
    listen(listener_, SOMAXCONN);
    accepting_ = std::thread([this] { Accept(); });
  }
  ~Relay() {
    shutdown(listener_, SHUT_RDWR);
    accepting_.join();
    close(listener_);
    const MutexLock lock(&mutex_);
    for (Pair& pair : pairs_) pair.End();
    for (std::thread& thread : threads_) thread.join();
    for (const Pair& pair : pairs_) {
      close(pair.near);
      close(pair.far);
    }
  }
  Relay(const Relay&) = delete;  // its threads use it

  std::string address() const {
    sockaddr_in own = {};
    socklen_t size = sizeof(own);
    getsockname(listener_, reinterpret_cast<sockaddr*>(&own), &size);
    return "127.0.0.1:" + std::to_string(ntohs(own.sin_port));
  }
  // The present connections carry nothing more, and neither end is told. Later ones work.
  void Silence() {
    const MutexLock lock(&mutex_);
    for (Pair& pair : pairs_) pair.silent = true;
  }
  // Pieces that the server has sent so far.
  uint64_t answers() const { return answers_; }

 private:
  struct Pair {
    Pair(int accepted, int connected) : near(accepted), far(connected) {}
    void End() const {
      shutdown(near, SHUT_RDWR);
      shutdown(far, SHUT_RDWR);
    }
    const int near, far;
    std::atomic<bool> silent = false;
  };

  static sockaddr_in Loopback(int port) {
    sockaddr_in address = {};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    return address;
  }
  static const sockaddr* Generic(const sockaddr_in& address) {
    return reinterpret_cast<const sockaddr*>(&address);
  }

  void Accept() {
    for (;;) {
      const int near = accept(listener_, nullptr, nullptr);
      if (near < 0) return;
      const int far = socket(AF_INET, SOCK_STREAM, 0);
      // A line holds little. The buffers of this machine would hold megabytes.
      const int held = 16'384;
      setsockopt(far, SOL_SOCKET, SO_RCVBUF, &held, sizeof(held));
      connect(far, Generic(target_), sizeof(target_));
      const MutexLock lock(&mutex_);
      Pair& pair = pairs_.emplace_back(near, far);
      threads_.emplace_back([this, &pair] { Forward(pair, pair.near, pair.far, nullptr); });
      threads_.emplace_back([this, &pair] { Forward(pair, pair.far, pair.near, &answers_); });
    }
  }

  void Forward(const Pair& pair, int from, int to, std::atomic<uint64_t>* count) const {
    std::vector<char> piece(8192);
    for (;;) {
      const ssize_t size = recv(from, piece.data(), piece.size(), 0);
      if (size <= 0) break;
      if (pair.silent) continue;
      if (rate_ > 0) {
        std::this_thread::sleep_for(
            std::chrono::duration<double>(static_cast<double>(size) / rate_));
      }
      if (!SendAll(to, piece.data(), static_cast<size_t>(size))) break;
      if (count != nullptr) ++*count;
    }
    if (!pair.silent) pair.End();
  }
  static bool SendAll(int to, const char* bytes, size_t size) {
    while (size > 0) {
      const ssize_t sent = send(to, bytes, size, MSG_NOSIGNAL);
      if (sent <= 0) return false;
      bytes += sent;
      size -= static_cast<size_t>(sent);
    }
    return true;
  }

  const sockaddr_in target_;
  const double rate_;
  const int listener_ = socket(AF_INET, SOCK_STREAM, 0);
  std::atomic<uint64_t> answers_ = 0;
  Mutex mutex_;
  std::list<Pair> pairs_;
  std::vector<std::thread> threads_;  // two for each pair
  std::thread accepting_;
};

}  // namespace latticed::client

#endif  // LATTICED_TESTS_CLIENT_RELAY_H_
