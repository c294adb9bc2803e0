// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Listens on a port, at every address of a name, and gives the sockets to one function. While the process
// has no file descriptor left it tries again. An exception of the function ends only that socket.
//
// Threads  safe
#ifndef LATTICED_SERVER_EDGE_TCP_LISTENER_H_
#define LATTICED_SERVER_EDGE_TCP_LISTENER_H_

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/strand.hpp>
#include <functional>
#include <list>
#include <memory>
#include <string>

#include "absl/status/statusor.h"

namespace latticed {

// Runs the context on the calling thread until it is stopped or has no work. An exception of a handler ends
// its connection, so that nothing a client sends ends the process.
void RunUntilDone(boost::asio::io_context& context);

// The address of the other end, as limits by address count it (server/base/address.h). Empty for one that is
// not counted: loopback, unless `counts_loopback`.
[[nodiscard]] std::string CountedAddress(const boost::asio::ip::tcp::socket& socket,
                                         bool counts_loopback);

class TcpListener : public std::enable_shared_from_this<TcpListener> {
 public:
  // Called for one socket after the other. TCP_NODELAY is set.
  using OnSocket = std::function<void(boost::asio::ip::tcp::socket)>;

  // Listens on `listen`, "host:port"; errors name `flag`. The context outlives the listener. kUnavailable
  // for a port that cannot be opened, kInvalidArgument for an invalid address.
  [[nodiscard]] static absl::StatusOr<std::shared_ptr<TcpListener>> Open(
      boost::asio::io_context& context, const std::string& flag, const std::string& listen,
      OnSocket on_socket);

  const std::string& address() const { return address_; }  // with the port that was taken
  void Close();

 private:
  struct Port {
    explicit Port(TcpListener& listener) : acceptor(listener.strand_), retry(listener.strand_) {}
    boost::asio::ip::tcp::acceptor acceptor;
    boost::asio::steady_timer retry;
  };

  TcpListener(boost::asio::io_context& context, OnSocket on_socket);
  absl::Status Bind(const std::string& host, const std::string& port);
  void Accept(Port& port);

  boost::asio::io_context& context_;
  const boost::asio::strand<boost::asio::io_context::executor_type> strand_;
  const OnSocket on_socket_;
  std::list<Port> ports_;  // on the strand; one an address
  std::string address_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_EDGE_TCP_LISTENER_H_
