// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A time by which something must happen. It may be moved or cleared.
//
// Threads  on the executor's strand
#ifndef LATTICED_SERVER_WEB_DEADLINE_H_
#define LATTICED_SERVER_WEB_DEADLINE_H_

#include <boost/asio/steady_timer.hpp>
#include <memory>
#include <utility>

#include "server/web/transport.h"

namespace latticed::web {

class Deadline {
 public:
  explicit Deadline(const Transport::executor_type& executor) : timer_(executor) {}

  // Replaces the earlier time, and calls `missed` of `owner` unless it is moved or cleared before. This
  // object is a member of `owner`.
  template <typename Owner>
  void Set(net::steady_timer::duration after, std::weak_ptr<Owner> owner, void (Owner::*missed)()) {
    timer_.expires_after(after);
    timer_.async_wait([this, owner = std::move(owner), missed](error_code failure) {
      const auto alive = owner.lock();  // and with it this
      if (alive == nullptr || failure) return;
      // A wait that had ended before the time was moved has no failure.
      if (timer_.expiry() <= net::steady_timer::clock_type::now()) ((*alive).*missed)();
    });
  }
  void Clear() { timer_.expires_at(net::steady_timer::time_point::max()); }

 private:
  net::steady_timer timer_;
};

}  // namespace latticed::web

#endif  // LATTICED_SERVER_WEB_DEADLINE_H_
