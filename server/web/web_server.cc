// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/web/web_server.h"

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <thread>
#include <utility>
#include <vector>

#include "absl/time/clock.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/base/telemetry.h"
#include "server/net/tcp_listener.h"
#include "server/net/tls_context.h"
#include "server/web/connection_set.h"
#include "server/web/http_answers.h"
#include "server/web/http_connection.h"
#include "server/web/request_guard.h"
#include "server/web/router.h"
#include "server/web/transport.h"

namespace latticed::web {
namespace {

// Two threads are enough, because they only move bytes. Other threads evaluate and encode.
constexpr int kThreads = 2;

const HttpHandler kRefuse = [](const std::shared_ptr<HttpExchange>& exchange) {
  HttpResponse answer = TextAnswer(503, "this server has reached its limit of connections");
  answer.fields.push_back({"retry-after", "1"});
  answer.fields.push_back({"connection", "close"});
  exchange->Reply(std::move(answer));
};

// Listens on `listen`, "host:port", for `flag`. Connections above the set's limit are answered 503 and closed;
// those far above it are closed at once. `tls` may be null; it and `connections` outlive the listener.
// kUnavailable if the address cannot be opened, kInvalidArgument if it has no port.
absl::StatusOr<std::shared_ptr<TcpListener>> ListenForHttp(
    net::io_context& io, const std::string& flag, const std::string& listen, const CurrentTls* tls,
    bool counts_loopback, ConnectionSet* connections, const HttpTimeouts& timeouts,
    const HttpHandler& handler) {
  return TcpListener::Open(io, flag, listen, [=](net::ip::tcp::socket socket) {
    error_code ignored;
    socket.set_option(net::socket_base::keep_alive(true), ignored);  // notices vanished clients
    auto place = connections->Enter(CountedAddress(socket, counts_loopback));
    if (place == nullptr) return;
    const bool served = place->served();
    HttpTimeouts patience = timeouts;
    if (!served) patience.idle = patience.head;
    const TlsContextPtr context = tls == nullptr ? nullptr : tls->Get();
    ServeConnection(Transport(std::move(socket), context.get()), std::move(place), patience,
                    served ? handler : kRefuse);
  });
}

}  // namespace

struct WebServer::Impl {
  Impl(const Options& options, ServerChannel channel, AdminHooks admin)
      : connections(MostConnections(options), MostOfAddress(options)),
        admin_connections(limits::kMaxAdminConnections, ConnectionSet::kReplaceOldest),
        router(options, std::move(channel)),
        admin_guard(options.admin, options.allowed_hosts, {}),
        admin_hooks(std::move(admin)),
        work(net::make_work_guard(context)),
        admin_work(net::make_work_guard(admin_context)) {}

  // The connections of --http; none if it is not served.
  ConnectionCounts counts() const {
    return http == nullptr ? ConnectionCounts() : connections.counts();
  }

  ConnectionSet connections, admin_connections;  // before the context, whose handlers hold places
  Router router;
  const RequestGuard admin_guard;
  const AdminHooks admin_hooks;
  CurrentTls tls;
  net::io_context context, admin_context;  // calls cannot keep the admin's port waiting
  net::executor_work_guard<net::io_context::executor_type> work, admin_work;
  std::shared_ptr<TcpListener> http, admin;
  std::vector<std::thread> threads;
};

WebServer::WebServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

WebServer::~WebServer() { Stop(); }

absl::StatusOr<std::unique_ptr<WebServer>> WebServer::Start(const Options& options,
                                                            ServerChannel channel,
                                                            AdminHooks admin) {
  std::unique_ptr<WebServer> server(
      new WebServer(std::make_unique<Impl>(options, std::move(channel), std::move(admin))));
  Impl& impl = *server->impl_;
  LATTICED_ASSIGN_OR_RETURN(const auto tls, ReadTls(options));
  if (tls != nullptr) server->SetTls(tls->context);
  if (!options.http.empty()) {
    LATTICED_ASSIGN_OR_RETURN(
        impl.http, ListenForHttp(impl.context, "--http", options.http, &impl.tls,
                                 CountsLoopback(options), &impl.connections, options.http_timeouts,
                                 [&impl](const auto& exchange) { impl.router.Answer(exchange); }));
  }
  if (!options.admin.empty()) {
    const HttpHandler answer = [&impl](const std::shared_ptr<HttpExchange>& exchange) {
      auto stopped = impl.admin_guard.Stop(exchange->request());
      exchange->Reply(stopped.has_value()
                          ? *std::move(stopped)
                          : AdminAnswer(impl.admin_hooks, exchange->request(), impl.counts()));
    };
    LATTICED_ASSIGN_OR_RETURN(
        impl.admin, ListenForHttp(impl.admin_context, "--admin", options.admin, nullptr, false,
                                  &impl.admin_connections, options.http_timeouts, answer));
  }
  for (int i = 0; i < kThreads; ++i) {
    impl.threads.emplace_back([&impl] { RunUntilDone(impl.context); });
  }
  impl.threads.emplace_back([&impl] { RunUntilDone(impl.admin_context); });
  return server;
}

void WebServer::SetTls(TlsContextPtr context) { impl_->tls.Set(std::move(context)); }

std::string WebServer::http_address() const {
  return impl_->http == nullptr ? "" : impl_->http->address();
}

std::string WebServer::admin_address() const {
  return impl_->admin == nullptr ? "" : impl_->admin->address();
}

ConnectionCounts WebServer::connections() const { return impl_->counts(); }

void WebServer::Drain(absl::Time deadline) {
  if (impl_->http == nullptr || impl_->threads.empty()) return;
  impl_->http->Close();
  impl_->connections.Drain();
  if (!impl_->connections.AwaitEmpty(deadline)) impl_->connections.Abort();
}

void WebServer::Stop() {
  if (impl_->threads.empty()) return;
  for (const auto& listener : {impl_->http, impl_->admin}) {
    if (listener != nullptr) listener->Close();
  }
  for (ConnectionSet* set : {&impl_->connections, &impl_->admin_connections}) {
    set->Abort();
    // Cancelled calls hold their connections until the calls have ended.
    while (!set->AwaitEmpty(absl::Now() + absl::Seconds(10))) {
      LogEvent(spdlog::level::warn, "HTTP connections are slow to end", {});
    }
  }
  impl_->work.reset();
  impl_->admin_work.reset();
  impl_->context.stop();
  impl_->admin_context.stop();
  for (std::thread& thread : impl_->threads) thread.join();
  impl_->threads.clear();
  impl_->router.LogSums(absl::InfiniteFuture());
}

}  // namespace latticed::web
