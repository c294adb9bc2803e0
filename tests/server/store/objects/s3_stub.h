// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// s3_stub.py as a child process, with the bucket "meshes".
#ifndef LATTICED_TESTS_SERVER_STORE_OBJECTS_S3_STUB_H_
#define LATTICED_TESTS_SERVER_STORE_OBJECTS_S3_STUB_H_

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <stdexcept>
#include <string>

#include "server/store/objects/s3_options.h"

namespace latticed::testing {

class S3Stub {
 public:
  static constexpr char kSecret[] = "wJalrXUtnFEMI/K7MDENG+bPxRfiCYsecret";

  explicit S3Stub(const std::string& token = "") {
    std::array<int, 2> in{}, out{};
    if (pipe2(in.data(), O_CLOEXEC) != 0 || pipe2(out.data(), O_CLOEXEC) != 0) {
      throw std::runtime_error("no pipe");
    }
    process_ = fork();
    if (process_ == 0) {
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      dup2(in[0], STDIN_FILENO);
      dup2(out[1], STDOUT_FILENO);
      execlp("python3", "python3", S3_STUB, "meshes", "us-east-1", "AKIDEXAMPLE", kSecret,
             token.c_str(), nullptr);
      _exit(127);
    }
    close(in[0]);
    close(out[1]);
    commands_ = fdopen(in[1], "w");
    answers_ = fdopen(out[0], "r");
    port_ = ReadLine();
  }
  ~S3Stub() {
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
    fclose(commands_);
    fclose(answers_);
  }
  S3Stub(const S3Stub&) = delete;  // one process
  S3Stub& operator=(const S3Stub&) = delete;

  std::string endpoint() const { return "http://127.0.0.1:" + port_; }
  // What a client needs that may use the bucket.
  S3Options options() const {
    return {.bucket = "meshes",
            .prefix = "some/",
            .endpoint = endpoint(),
            .region = "us-east-1",
            .access_key = "AKIDEXAMPLE",
            .secret_key = kSecret,
            .patience = absl::Seconds(1),
            .first_pause = absl::Milliseconds(2),
            .most_time = absl::Seconds(2)};
  }
  // A command of s3_stub.py, and its answer.
  std::string Execute(const std::string& command) {
    fputs((command + "\n").c_str(), commands_);
    fflush(commands_);
    return ReadLine();
  }

 private:
  std::string ReadLine() {
    std::array<char, 4'096> line{};
    if (fgets(line.data(), line.size(), answers_) == nullptr) {
      throw std::runtime_error("the stub of S3 has ended");
    }
    const std::string text(line.data());
    return text.substr(0, text.find('\n'));
  }

  pid_t process_ = -1;
  FILE* commands_ = nullptr;
  FILE* answers_ = nullptr;
  std::string port_;
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_STORE_OBJECTS_S3_STUB_H_
