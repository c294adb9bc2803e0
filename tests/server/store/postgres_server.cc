// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/server/store/postgres_server.h"

#include <arpa/inet.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>

#include "absl/time/clock.h"
#include "fmt/format.h"
#include "server/store/postgres/connection.h"

namespace latticed::testing {
namespace {

// Of the newest version; empty if there is none.
std::string Programs() {
  std::string newest;
  std::error_code none;
  for (const auto& version : std::filesystem::directory_iterator("/usr/lib/postgresql", none)) {
    const std::string path = version.path().string() + "/bin";
    if (std::filesystem::exists(path + "/initdb")) newest = std::max(newest, path);
  }
  return newest;
}

// PostgreSQL does not run as root. It ends with the test.
std::string AsUser(const std::string& command) {
  if (geteuid() != 0) return fmt::format("exec setpriv --pdeathsig QUIT {}", command);
  return fmt::format(
      "exec setpriv --reuid postgres --regid postgres --clear-groups --pdeathsig QUIT {}", command);
}

// A port of 127.0.0.1 that nobody listens on.
int FreePort() {
  const int listener = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address = {.sin_family = AF_INET, .sin_addr = {htonl(INADDR_LOOPBACK)}};
  socklen_t size = sizeof(address);
  auto* const any = reinterpret_cast<sockaddr*>(&address);
  const bool bound = bind(listener, any, size) == 0 && getsockname(listener, any, &size) == 0;
  close(listener);
  if (!bound) throw std::runtime_error("no port is free");
  return ntohs(address.sin_port);
}

}  // namespace

bool PostgresServer::IsInstalled() { return !Programs().empty(); }

PostgresServer& PostgresServer::Shared() {
  static PostgresServer server;
  return server;
}

PostgresServer::PostgresServer(Network network, Disk disk)
    : port_(network == Network::kTcp ? FreePort() : 0), disk_(disk) {
  const std::string folder = folder_.path().string();
  const std::string owner =
      geteuid() == 0 ? fmt::format("chown postgres {} && ", folder) : std::string();
  const std::string data = folder_.Path("data");
  const std::string make = fmt::format(
      "{}({}) > {}", owner,
      AsUser(fmt::format("{}/initdb -D {} -A trust -U latticed -E UTF8 --locale C --no-sync",
                         Programs(), data)),
      folder_.Path("initdb.txt"));
  if (std::system(make.c_str()) != 0) throw std::runtime_error("initdb failed: " + make);
  Start();
}

void PostgresServer::Start() {
  const std::string serve = AsUser(fmt::format(
      "{}/postgres -D {} -k {} -c listen_addresses={} {} -c max_connections=200 > {} 2>&1",
      Programs(), folder_.Path("data"), folder_.path().string(),
      port_ == 0 ? std::string() : fmt::format("127.0.0.1 -p {}", port_),
      disk_ == Disk::kIgnored ? "-c fsync=off -c full_page_writes=off" : "",
      folder_.Path("log.txt")));
  process_ = fork();
  if (process_ == 0) {
    execl("/bin/sh", "sh", "-c", serve.c_str(), nullptr);
    _exit(127);
  }
  for (int i = 0; i < 600; ++i) {
    if (PgConnection::Open(UrlOf("postgres")).ok()) return;
    absl::SleepFor(absl::Milliseconds(100));
  }
  throw std::runtime_error("PostgreSQL does not start: " + folder_.Read("log.txt"));
}

PostgresServer::~PostgresServer() { Crash(); }

void PostgresServer::Crash() {
  kill(process_, SIGQUIT);
  waitpid(process_, nullptr, 0);
}

std::string PostgresServer::UrlOf(const std::string& database) const {
  if (port_ != 0) {
    return fmt::format("host=127.0.0.1 port={} user=latticed dbname={}", port_, database);
  }
  return fmt::format("host={} user=latticed dbname={}", folder_.path().string(), database);
}

std::string PostgresServer::NewDatabase() {
  const std::string name = fmt::format("test{}", ++databases_);
  ExecuteSql(UrlOf("postgres"), "CREATE DATABASE " + name);
  return UrlOf(name);
}

void ExecuteSql(const std::string& url, const std::string& sql) {
  absl::StatusOr<PgConnection> connection = PgConnection::Open(url);
  absl::Status status = connection.status();
  if (status.ok()) status = connection->Execute(sql.c_str());
  if (!status.ok()) throw std::runtime_error(status.ToString());
}

PostgresSetting::PostgresSetting(std::string url, std::string name, const std::string& value)
    : url_(std::move(url)), name_(std::move(name)) {
  ExecuteSql(url_, fmt::format("ALTER SYSTEM SET {} = {}", name_, value));
  ExecuteSql(url_, "SELECT pg_reload_conf()");
}

PostgresSetting::~PostgresSetting() {
  ExecuteSql(url_, "ALTER SYSTEM RESET " + name_);
  ExecuteSql(url_, "SELECT pg_reload_conf()");
}

std::vector<std::string> WithPostgres(std::vector<std::string> kinds) {
  if (PostgresServer::IsInstalled()) kinds.push_back("postgres");
  return kinds;
}

}  // namespace latticed::testing
