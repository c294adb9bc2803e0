// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A PostgreSQL in a temporary folder, for all tests of the program. Unless asked, it does not wait for the disk.
#ifndef LATTICED_TESTS_SERVER_STORE_POSTGRES_SERVER_H_
#define LATTICED_TESTS_SERVER_STORE_POSTGRES_SERVER_H_

#include <sys/types.h>

#include <string>
#include <vector>

#include "tests/support/temporary_folder.h"

namespace latticed::testing {

class PostgresServer {
 public:
  // Whether this machine has PostgreSQL's programs.
  static bool IsInstalled();
  // Started with the first call.
  static PostgresServer& Shared();

  enum class Network { kUnixSocket, kTcp };  // kTcp: a free port of 127.0.0.1
  enum class Disk { kIgnored, kAwaited };    // kAwaited: commits wait for it, as outside of tests
  explicit PostgresServer(Network network = Network::kUnixSocket, Disk disk = Disk::kIgnored);
  ~PostgresServer();

  // Ends at once, as after a crash: what was committed is found by the next start.
  void Crash();
  // After Crash, on the thread of the first start, with which it ends.
  void Start();
  // Makes an empty database, and returns its URL.
  std::string NewDatabase();

 private:
  std::string UrlOf(const std::string& database) const;

  const int port_;  // 0: there is none
  const Disk disk_;
  TemporaryFolder folder_;
  pid_t process_ = -1;
  int databases_ = 0;
};

// Executes SQL without rows; throws if it fails.
void ExecuteSql(const std::string& url, const std::string& sql);

// A setting of the whole PostgreSQL, for as long as this is. It takes it a little later.
class PostgresSetting {
 public:
  PostgresSetting(std::string url, std::string name, const std::string& value);
  ~PostgresSetting();
  PostgresSetting(const PostgresSetting&) = delete;  // it is taken back once
  PostgresSetting& operator=(const PostgresSetting&) = delete;

 private:
  const std::string url_;
  const std::string name_;
};

// `kinds`, and "postgres" if it is installed.
std::vector<std::string> WithPostgres(std::vector<std::string> kinds);

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_STORE_POSTGRES_SERVER_H_
