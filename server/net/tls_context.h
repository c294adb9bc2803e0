// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// TLS of --http from the files of --tls-cert, --tls-key and --tls-client-ca, which are read again on SIGHUP.
// gRPC reads the same files itself; a context made of them shows that they can be used.
//
// Threads  safe
#ifndef LATTICED_SERVER_NET_TLS_CONTEXT_H_
#define LATTICED_SERVER_NET_TLS_CONTEXT_H_

#include <boost/asio/ssl/context.hpp>
#include <memory>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/mutex.h"
#include "server/base/options.h"

namespace latticed {

using TlsContextPtr = std::shared_ptr<boost::asio::ssl::context>;

// Null if there is no --tls-cert. kInvalidArgument, naming the flag, if a file cannot be used.
[[nodiscard]] absl::StatusOr<TlsContextPtr> MakeTlsContext(const Options& options);

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
