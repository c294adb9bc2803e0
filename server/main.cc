// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The program latticed: parses the options, starts the server, waits for SIGTERM or SIGINT, and drains. On SIGHUP it
// reads tokens, certificates and the log level again. A watchdog ends it when the server does not move any more.
#include <semaphore.h>
#include <signal.h>
#include <time.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>

#include "absl/time/clock.h"
#include "server/base/options.h"
#include "server/base/process_memory.h"
#include "server/base/telemetry.h"
#include "server/base/version.h"
#include "server/base/watchdog.h"
#include "server/in_process.h"

namespace {

constexpr int kExitFailure = 1;
constexpr int kExitUsage = 2;
constexpr absl::Duration kLogPatience = absl::Seconds(1);
// For the server to end, after all calls were cancelled.
constexpr absl::Duration kStopPatience = absl::Seconds(30);

// A handler catches the signals. sigwait would not: libraries start threads before main, and these threads
// block no signals. One of them would receive the signal and end the program.
sem_t signal_semaphore;
std::atomic<int> stop_signal = 0;
std::atomic<bool> reload = false;
static_assert(std::atomic<int>::is_always_lock_free && std::atomic<bool>::is_always_lock_free,
              "set in a signal handler");

void OnSignal(int signal) {
  if (signal == SIGHUP) {
    reload = true;
  } else {
    stop_signal = signal;
  }
  sem_post(&signal_semaphore);
}

void CatchSignals() {
  sem_init(&signal_semaphore, 0, 0);
  struct sigaction action = {};
  action.sa_handler = OnSignal;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  sigaction(SIGTERM, &action, nullptr);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGHUP, &action, nullptr);
  // The program must not end when nobody reads its log any more, or when the log reaches the limit of a file's size.
  signal(SIGPIPE, SIG_IGN);
  signal(SIGXFSZ, SIG_IGN);
}

// Writes the waiting lines of the log. If nobody reads them, the process ends here.
void EndLog(int code) {
  if (!latticed::CloseLog(kLogPatience)) std::_Exit(code);
}

void Reload(latticed::InProcessServer& server, int argc, char** argv) {
  const auto again = latticed::ParseCommandLine(argc, argv);
  absl::Status status = again.status();
  if (status.ok()) status = server.Reload(again->options);
  if (status.ok()) {
    latticed::LogEvent(spdlog::level::info, "tokens, certificates and log level were read again",
                       {});
  } else {
    latticed::LogEvent(spdlog::level::err, "not all could be read again, the rest stays as it was",
                       {{"error", std::string(status.message())}});
  }
}

[[noreturn]] void EndStuckProcess() {
  latticed::LogEvent(spdlog::level::critical,
                     "the server does not move any more: the process ends, to be started again",
                     {});
  EndLog(kExitFailure);
  std::abort();  // leaves a core that shows where
}

// Returns the signal that stops the program.
int WaitForStopSignal(latticed::InProcessServer& server, int argc, char** argv) {
  latticed::Watchdog watchdog;
  while (stop_signal == 0) {
    timespec next{};
    clock_gettime(CLOCK_MONOTONIC, &next);
    ++next.tv_sec;
    const bool signalled = sem_clockwait(&signal_semaphore, CLOCK_MONOTONIC, &next) == 0;
    if (reload.exchange(false)) Reload(server, argc, argv);
    if (!signalled && errno == ETIMEDOUT && watchdog.IsStuck(server.TakePulse())) EndStuckProcess();
  }
  return stop_signal;
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

  CatchSignals();
  latticed::LimitFreeHeapEnds();
  auto server = latticed::InProcessServer::Serve(options);
  if (!server.ok()) return Fail(server.status(), kExitFailure);
  latticed::LogEvent(spdlog::level::info, "serving",
                     {{"address", (*server)->address()},
                      {"backend", (*server)->backend_description()},
                      {"http", (*server)->http_address()},
                      {"admin", (*server)->admin_address()},
                      {"version", std::string(latticed::Version())}});
  const int signal = WaitForStopSignal(**server, argc, argv);
  latticed::LogEvent(spdlog::level::info, "draining", {{"signal", std::to_string(signal)}});
  const absl::Duration most = options.drain_delay + options.drain_timeout + kStopPatience;
  std::thread([most] {
    absl::SleepFor(most);
    EndStuckProcess();
  }).detach();
  (*server)->Drain();
  latticed::LogEvent(spdlog::level::info, "stopped", {});
  server->reset();  // its threads log
  EndLog(0);
  return 0;
}
