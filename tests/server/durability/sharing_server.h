// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The program latticed as one of several servers that share a PostgreSQL and a folder of meshes.
#ifndef LATTICED_TESTS_SERVER_DURABILITY_SHARING_SERVER_H_
#define LATTICED_TESTS_SERVER_DURABILITY_SHARING_SERVER_H_

#include <memory>
#include <string>
#include <vector>

#include <grpcpp/grpcpp.h>

#include "absl/time/time.h"
#include "latticed/v1/scene.grpc.pb.h"
#include "tests/server/daemon/daemon_process.h"

namespace latticed::testing {

// Renewed every half a second: a busy machine keeps nobody from that for longer.
inline constexpr absl::Duration kLease = absl::Seconds(2);

inline std::vector<std::string> SharingArguments(const std::string& url_file,
                                                 const std::string& meshes, const std::string& name,
                                                 absl::Duration lease = kLease) {
  return {"--listen",         "127.0.0.1:0",
          "--backend",        "cpu",
          "--threads",        "1",
          "--drain-delay",    "0s",
          "--store",          "postgres",
          "--store-url-file", url_file,
          "--mesh-store",     meshes,
          "--advertise",      name,
          "--lease",          absl::FormatDuration(lease)};
}

class SharingServer {
 public:
  SharingServer(const std::string& url_file, const std::string& meshes, const std::string& name,
                absl::Duration lease = kLease)
      : daemon_(SharingArguments(url_file, meshes, name, lease)),
        channel_(grpc::CreateChannel(daemon_.Address(), grpc::InsecureChannelCredentials())),
        scenes_(v1::SceneService::NewStub(channel_)) {}
  ~SharingServer() {
    if (running_) End(SIGKILL);
  }

  // The exit status.
  int End(int signal) {
    Signal(signal);
    return Wait();
  }
  void Signal(int signal) { daemon_.Signal(signal); }
  int Wait() {
    running_ = false;
    return daemon_.Wait();
  }
  const std::shared_ptr<grpc::Channel>& channel() const { return channel_; }
  v1::SceneService::Stub& scenes() { return *scenes_; }

 private:
  Daemon daemon_;
  const std::shared_ptr<grpc::Channel> channel_;
  const std::unique_ptr<v1::SceneService::Stub> scenes_;
  bool running_ = true;
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_DURABILITY_SHARING_SERVER_H_
