// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Turns SIGINT and SIGTERM into a request to stop, for commands that must first delete scenes and
// meshes on a server. A signal that was ignored when the process started stays ignored.
//
//   Interruption interruption;
//   const std::stop_token stop = interruption.Catch();
//
// Threads  one object at a time in a process; used by one thread, the token by any
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_COMMAND_LINE_INTERRUPTION_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_COMMAND_LINE_INTERRUPTION_H_

#include <atomic>
#include <stop_token>
#include <thread>

namespace latticed::client {

class Interruption {
 public:
  Interruption() = default;  // catches nothing yet
  // Restores the signals' actions.
  ~Interruption();
  Interruption(const Interruption&) = delete;  // its thread uses its address
  Interruption& operator=(const Interruption&) = delete;

  // May be called once. The first signal from now on requests the stop, and restores the previous
  // actions: a user can end the deletion by a second signal.
  [[nodiscard]] std::stop_token Catch();
  // The signal that was caught; 0: none.
  int signal() const;

 private:
  std::stop_source stop_;
  std::atomic<bool> over_ = false;
  std::thread thread_;  // requests the stop, which a signal handler may not
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_COMMAND_LINE_INTERRUPTION_H_
