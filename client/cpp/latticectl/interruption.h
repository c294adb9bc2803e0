// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// SIGINT and SIGTERM as a request to stop, for a command that must delete first what it has made on
// a server. A signal that the process was started to ignore stays ignored.
//
//   Interruption interruption;
//   const std::stop_token stop = interruption.Catch();
//
// Threads  one object at a time in a process; used by one thread, the token by any
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_INTERRUPTION_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_INTERRUPTION_H_

#include <atomic>
#include <stop_token>
#include <thread>

namespace latticed::client {

class Interruption {
 public:
  Interruption() = default;  // catches nothing yet
  // The signals do again what they did before Catch.
  ~Interruption();
  Interruption(const Interruption&) = delete;  // its thread waits at its address
  Interruption& operator=(const Interruption&) = delete;

  // Once: the first signal from now on requests the stop; a second one does what it did before, so
  // that tidying up can be cut short.
  [[nodiscard]] std::stop_token Catch();
  // The signal that was caught; 0: none.
  int signal() const;

 private:
  std::stop_source stop_;
  std::atomic<bool> over_ = false;
  std::thread thread_;  // requests the stop, which a signal handler may not
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_INTERRUPTION_H_
