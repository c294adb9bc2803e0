// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The program latticed: parses the options, starts the server, waits for SIGTERM or SIGINT, and drains.
#include <semaphore.h>
#include <signal.h>

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "server/base/options.h"
#include "server/base/telemetry.h"
#include "server/base/version.h"
#include "server/in_process.h"

namespace {

constexpr int kExitFailure = 1;
constexpr int kExitUsage = 2;
constexpr absl::Duration kLogPatience = absl::Seconds(1);

// A handler catches the signals. sigwait would not: libraries start threads before main, and these threads
// block no signals. One of them would receive the signal and end the program.
sem_t stop_semaphore;
std::atomic<int> stop_signal = 0;
static_assert(std::atomic<int>::is_always_lock_free, "set in a signal handler");

void OnStopSignal(int signal) {
  stop_signal = signal;
  sem_post(&stop_semaphore);
}

void CatchStopSignals() {
  sem_init(&stop_semaphore, 0, 0);
  struct sigaction action = {};
  action.sa_handler = OnStopSignal;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  sigaction(SIGTERM, &action, nullptr);
  sigaction(SIGINT, &action, nullptr);
  // The program must not end when nobody reads its log any more, or when the log reaches the limit of a file's size.
  signal(SIGPIPE, SIG_IGN);
  signal(SIGXFSZ, SIG_IGN);
}

int WaitForStopSignal() {
  while (sem_wait(&stop_semaphore) != 0) {
  }
  return stop_signal;
}

// Writes the waiting lines of the log. If nobody reads them, the process ends here.
void EndLog(int code) {
  if (!latticed::CloseLog(kLogPatience)) std::_Exit(code);
}

int Fail(const absl::Status& status, int code) {
  EndLog(code);
  std::fprintf(stderr, "latticed: %s\n", std::string(status.message()).c_str());
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  const auto command_line = latticed::ParseCommandLine(argc, argv);
  if (!command_line.ok()) return Fail(command_line.status(), kExitUsage);
  if (command_line->text.has_value()) {
    std::fputs(command_line->text->c_str(), stdout);
    return 0;
  }
  const latticed::Options& options = command_line->options;

  CatchStopSignals();
  auto server = latticed::InProcessServer::Serve(options);
  if (!server.ok()) return Fail(server.status(), kExitFailure);
  latticed::LogEvent(spdlog::level::info, "serving",
                     {{"address", (*server)->address()},
                      {"backend", (*server)->backend_description()},
                      {"http", (*server)->http_address()},
                      {"admin", (*server)->admin_address()},
                      {"version", std::string(latticed::Version())}});
  const int signal = WaitForStopSignal();
  latticed::LogEvent(spdlog::level::info, "draining", {{"signal", std::to_string(signal)}});
  (*server)->Drain();
  latticed::LogEvent(spdlog::level::info, "stopped", {});
  server->reset();  // its threads log
  EndLog(0);
  return 0;
}
