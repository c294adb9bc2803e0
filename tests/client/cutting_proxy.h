// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A TCP proxy on a free port of the loopback that can break all of its connections.
//
// Threads  any may call
#ifndef LATTICED_TESTS_CLIENT_CUTTING_PROXY_H_
#define LATTICED_TESTS_CLIENT_CUTTING_PROXY_H_

#include <string>
#include <thread>
#include <vector>

#include "core/base/mutex.h"

namespace latticed::client {

class CuttingProxy {
 public:
  // Forwards to "127.0.0.1:port". Fails the test where it cannot listen.
  explicit CuttingProxy(const std::string& target);
  CuttingProxy(const CuttingProxy&) = delete;
  CuttingProxy& operator=(const CuttingProxy&) = delete;
  ~CuttingProxy();

  std::string address() const { return "127.0.0.1:" + std::to_string(port_); }
  // Those that there are; the next ones work.
  void Cut();

 private:
  void Accept();

  const int target_port_;
  int listener_ = -1;
  int port_ = 0;
  std::thread acceptor_;
  Mutex mutex_;
  std::vector<int> sockets_ ABSL_GUARDED_BY(mutex_);
  std::vector<std::thread> forwarders_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace latticed::client

#endif  // LATTICED_TESTS_CLIENT_CUTTING_PROXY_H_
