// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/client/cutting_proxy.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>

#include "gtest/gtest.h"

namespace latticed::client {
namespace {

sockaddr_in Loopback(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

bool SendAll(int sink, const char* data, size_t size) {
  while (size > 0) {
    const ssize_t sent = send(sink, data, size, MSG_NOSIGNAL);
    if (sent <= 0) return false;
    data += sent;
    size -= static_cast<size_t>(sent);
  }
  return true;
}

// Until either end is shut down; then both are.
void Forward(int source, int sink) {
  std::array<char, 65536> buffer;
  for (;;) {
    const ssize_t got = recv(source, buffer.data(), buffer.size(), 0);
    if (got <= 0 || !SendAll(sink, buffer.data(), static_cast<size_t>(got))) break;
  }
  shutdown(source, SHUT_RDWR);
  shutdown(sink, SHUT_RDWR);
}

}  // namespace

CuttingProxy::CuttingProxy(const std::string& target)
    : target_port_(std::stoi(target.substr(target.rfind(':') + 1))),
      listener_(socket(AF_INET, SOCK_STREAM, 0)) {
  sockaddr_in address = Loopback(0);
  socklen_t size = sizeof(address);
  EXPECT_EQ(bind(listener_, reinterpret_cast<sockaddr*>(&address), size), 0);
  EXPECT_EQ(listen(listener_, SOMAXCONN), 0);
  EXPECT_EQ(getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size), 0);
  port_ = ntohs(address.sin_port);
  acceptor_ = std::thread([this] { Accept(); });
}

CuttingProxy::~CuttingProxy() {
  shutdown(listener_, SHUT_RDWR);
  acceptor_.join();
  Cut();
  const MutexLock lock(&mutex_);  // of nobody else by now
  for (std::thread& forwarder : forwarders_) forwarder.join();
  for (const int end : sockets_) close(end);
  close(listener_);
}

void CuttingProxy::Cut() {
  const MutexLock lock(&mutex_);
  for (const int end : sockets_) shutdown(end, SHUT_RDWR);
}

void CuttingProxy::Accept() {
  for (;;) {
    const int near = accept(listener_, nullptr, nullptr);
    if (near < 0) return;
    const int far = socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in target = Loopback(target_port_);
    if (connect(far, reinterpret_cast<sockaddr*>(&target), sizeof(target)) != 0) {
      shutdown(near, SHUT_RDWR);
    }
    const MutexLock lock(&mutex_);
    sockets_.insert(sockets_.end(), {near, far});
    forwarders_.emplace_back(Forward, near, far);
    forwarders_.emplace_back(Forward, far, near);
  }
}

}  // namespace latticed::client
