// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A time by which something must have happened, which may be moved or taken back.
//
// Threads  on the executor's strand
#ifndef LATTICED_SERVER_WEB_DEADLINE_H_
#define LATTICED_SERVER_WEB_DEADLINE_H_

#include <boost/asio/steady_timer.hpp>
#include <functional>
#include <memory>
#include <utility>

#include "server/web/transport.h"

namespace latticed::web {

class Deadline {
 public:
  explicit Deadline(const Transport::executor_type& executor)
      : timer_(std::make_shared<net::steady_timer>(executor)) {}
  ~Deadline() { Clear(); }
  Deadline(const Deadline&) = delete;  // one owner clears it
  Deadline& operator=(const Deadline&) = delete;

  // In place of the time before. `missed` is not called once that has been moved or cleared.
  void Set(net::steady_timer::duration after, std::function<void()> missed) {
    timer_->expires_after(after);
    timer_->async_wait([timer = timer_, missed = std::move(missed)](error_code failure) {
      // A wait that had ended before the time was moved has no failure.
      if (!failure && timer->expiry() <= net::steady_timer::clock_type::now()) missed();
    });
  }
  void Clear() { timer_->expires_at(net::steady_timer::time_point::max()); }

 private:
  const std::shared_ptr<net::steady_timer> timer_;
};

}  // namespace latticed::web

#endif  // LATTICED_SERVER_WEB_DEADLINE_H_
