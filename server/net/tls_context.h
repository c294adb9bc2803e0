// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// TLS from the files of --tls-cert, --tls-key and --tls-client-ca, which are read at start and again on SIGHUP.
//
// Threads  safe
#ifndef LATTICED_SERVER_NET_TLS_CONTEXT_H_
#define LATTICED_SERVER_NET_TLS_CONTEXT_H_

#include <boost/asio/ssl/context.hpp>
#include <memory>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/mutex.h"
#include "server/base/options.h"

namespace latticed {

using TlsContextPtr = std::shared_ptr<boost::asio::ssl::context>;

// What was read, and is known to fit together.
struct Tls {
  std::string certificate;  // PEM, with its chain
  std::string key;          // PEM, nothing else
  std::string client_ca;    // PEM; empty: clients need no certificate
  TlsContextPtr context;    // of the same
};

// Null if there is no --tls-cert. kInvalidArgument, naming the flag, if a file cannot be used.
[[nodiscard]] absl::StatusOr<std::shared_ptr<const Tls>> ReadTls(const Options& options);

// The context of new connections; older ones keep theirs.
class CurrentTls {
 public:
  void Set(TlsContextPtr context) ABSL_LOCKS_EXCLUDED(mutex_) {
    const MutexLock lock(&mutex_);
    context_.swap(context);
  }
  [[nodiscard]] TlsContextPtr Get() const ABSL_LOCKS_EXCLUDED(mutex_) {
    const MutexLock lock(&mutex_);
    return context_;
  }

 private:
  mutable Mutex mutex_;
  TlsContextPtr context_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace latticed

#endif  // LATTICED_SERVER_NET_TLS_CONTEXT_H_
