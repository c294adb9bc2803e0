// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Serves a test's own services, which may misbehave, on a free loopback port.
#ifndef LATTICED_TESTS_CLIENT_FAKE_SERVER_H_
#define LATTICED_TESTS_CLIENT_FAKE_SERVER_H_

#include <grpcpp/grpcpp.h>

#include <initializer_list>
#include <memory>
#include <string>

namespace latticed::client {

class FakeServer {
 public:
  // The services must outlive the server.
  explicit FakeServer(std::initializer_list<grpc::Service*> services) {
    grpc::ServerBuilder builder;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port_);
    for (grpc::Service* service : services) builder.RegisterService(service);
    server_ = builder.BuildAndStart();
  }

  std::string address() const { return "127.0.0.1:" + std::to_string(port_); }
  // Returns when all calls have ended.
  void Shutdown() { server_->Shutdown(); }

 private:
  int port_ = 0;
  std::unique_ptr<grpc::Server> server_;
};

}  // namespace latticed::client

#endif  // LATTICED_TESTS_CLIENT_FAKE_SERVER_H_
