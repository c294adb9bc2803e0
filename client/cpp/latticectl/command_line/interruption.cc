// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/command_line/interruption.h"

#include <semaphore.h>
#include <signal.h>

#include <array>
#include <cerrno>
#include <cstddef>

namespace latticed::client {
namespace {

// A handler is used and not sigwait: threads that libraries start do not block these signals, so the
// kernel could deliver a signal to one of them.
constexpr std::array<int, 2> kSignals = {SIGINT, SIGTERM};
std::array<struct sigaction, 2> actions_before;
std::atomic<int> caught = 0;
static_assert(std::atomic<int>::is_always_lock_free, "set in a signal handler");
sem_t wake;

void RestoreActions() {
  for (size_t i = 0; i < kSignals.size(); ++i) {
    sigaction(kSignals[i], &actions_before[i], nullptr);
  }
}

void OnSignal(int signal) {
  const int error = errno;
  RestoreActions();
  caught = signal;
  sem_post(&wake);
  errno = error;
}

}  // namespace

std::stop_token Interruption::Catch() {
  caught = 0;
  sem_init(&wake, 0, 0);
  thread_ = std::thread([this] {
    while (caught == 0 && !over_) (void)sem_wait(&wake);
    if (caught != 0) stop_.request_stop();
  });
  for (size_t i = 0; i < kSignals.size(); ++i) {
    sigaction(kSignals[i], nullptr, &actions_before[i]);
  }
  struct sigaction action = {};
  action.sa_handler = OnSignal;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  for (size_t i = 0; i < kSignals.size(); ++i) {
    if (actions_before[i].sa_handler != SIG_IGN) sigaction(kSignals[i], &action, nullptr);
  }
  return stop_.get_token();
}

Interruption::~Interruption() {
  if (!thread_.joinable()) return;
  RestoreActions();
  over_ = true;
  sem_post(&wake);
  thread_.join();
}

int Interruption::signal() const { return thread_.joinable() ? caught.load() : 0; }

}  // namespace latticed::client
