// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/edge/open_calls.h"

#include <arpa/inet.h>
#include <grpc/grpc.h>
#include <grpc/support/alloc.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>

#include "absl/strings/escaping.h"
#include "absl/strings/numbers.h"
#include "fmt/format.h"

namespace latticed {
namespace {

using nlohmann::json;

constexpr auto kListAllEvery = std::chrono::seconds(1);

// channelz answers in the JSON of its protocol: what is zero or empty is absent, int64 is text. What
// has ended meanwhile is null; then everything is absent.
json Parse(char* answer) {
  json parsed = answer == nullptr ? json() : json::parse(answer, nullptr, false);
  gpr_free(answer);
  return parsed;
}

json At(const json& object, const char* path) {
  const json::json_pointer pointer(path);
  return object.is_object() && object.contains(pointer) ? object.at(pointer) : json();
}

json ListAt(const json& object, const char* path) {
  json list = At(object, path);
  return list.is_array() ? list : json::array();
}

std::string Text(const json& object, const char* path) {
  const json text = At(object, path);
  return text.is_string() ? text.get<std::string>() : "";
}

int64_t Number(const json& object, const char* path) {
  int64_t number = 0;
  return absl::SimpleAtoi(Text(object, path), &number) ? number : 0;
}

// Of "chttp2 ipv4:127.0.0.1:40530" and "chttp2 ipv6:%5B::1%5D:40530".
uint16_t PortIn(const std::string& name) {
  int port = 0;
  return absl::SimpleAtoi(name.substr(name.rfind(':') + 1), &port) ? static_cast<uint16_t>(port)
                                                                   : 0;
}

Endpoint EndpointIn(const json& address) {
  Endpoint result;
  if (!absl::Base64Unescape(Text(address, "/tcpip_address/ip_address"), &result.address)) return {};
  const json port = At(address, "/tcpip_address/port");
  if (port.is_number_integer()) result.port = port.get<uint16_t>();
  return result;
}

using GetName = int (*)(int, sockaddr*, socklen_t*);

Endpoint EndpointOf(int socket, GetName get_name) {
  sockaddr_storage storage = {};
  socklen_t size = sizeof(storage);
  if (get_name(socket, reinterpret_cast<sockaddr*>(&storage), &size) != 0) return {};
  if (storage.ss_family == AF_INET) {
    const auto& v4 = reinterpret_cast<const sockaddr_in&>(storage);
    return {.address = {reinterpret_cast<const char*>(&v4.sin_addr), sizeof(v4.sin_addr)},
            .port = ntohs(v4.sin_port)};
  }
  if (storage.ss_family != AF_INET6) return {};
  constexpr size_t kPrefix = 12;  // ::ffff:0:0/96
  const auto& v6 = reinterpret_cast<const sockaddr_in6&>(storage);
  std::string address(reinterpret_cast<const char*>(&v6.sin6_addr), sizeof(v6.sin6_addr));
  if (IN6_IS_ADDR_V4MAPPED(&v6.sin6_addr)) address.erase(0, kPrefix);
  return {.address = address, .port = ntohs(v6.sin6_port)};
}

}  // namespace

std::string Endpoint::Name() const {
  const bool v4 = address.size() == sizeof(in_addr);
  if (!v4 && address.size() != sizeof(in6_addr)) return "";
  char text[INET6_ADDRSTRLEN] = {};
  inet_ntop(v4 ? AF_INET : AF_INET6, address.data(), text, sizeof(text));
  return v4 ? fmt::format("ipv4:{}:{}", text, port) : fmt::format("ipv6:[{}]:{}", text, port);
}

Connection Connection::Of(int socket) {
  return {.local = EndpointOf(socket, getsockname), .remote = EndpointOf(socket, getpeername)};
}

void OpenCalls::List() {
  const auto now = std::chrono::steady_clock::now();
  if (now >= all_again_) {
    all_again_ = now + kListAllEvery;
    sockets_.clear();
    next_ = 0;
  }
  const SocketNumber first = next_;
  const json servers = Parse(grpc_channelz_get_servers(0));
  for (const json& server : ListAt(servers, "/server")) {
    const intptr_t id = Number(server, "/ref/serverId");
    bool end = false;
    for (SocketNumber next = first; !end;) {
      const json page = Parse(grpc_channelz_get_server_sockets(id, next, 0));
      const json list = ListAt(page, "/socketRef");
      for (const json& socket : list) {
        const SocketNumber number = Number(socket, "/socketId");
        sockets_.emplace(PortIn(Text(socket, "/name")), number);
        next = number + 1;
      }
      next_ = std::max(next_, next);
      end = list.empty() || At(page, "/end") == true;
    }
  }
}

SocketNumber OpenCalls::NumberOf(const Connection& connection) const {
  // The newest: an ended one may be listed as long as a handler has a call of it.
  SocketNumber newest = kNoSocket;
  const auto [begin, end] = sockets_.equal_range(connection.remote.port);
  for (auto candidate = begin; candidate != end; ++candidate) {
    const json socket = Parse(grpc_channelz_get_socket(candidate->second));
    const Connection ends{.local = EndpointIn(At(socket, "/socket/local")),
                          .remote = EndpointIn(At(socket, "/socket/remote"))};
    if (ends == connection) newest = std::max(newest, candidate->second);
  }
  return newest;
}

std::optional<int64_t> OpenCalls::Of(SocketNumber number) {
  const json socket = Parse(grpc_channelz_get_socket(number));
  if (!socket.is_object()) return std::nullopt;
  const json data = At(socket, "/socket/data");
  return Number(data, "/streamsStarted") - Number(data, "/streamsSucceeded") -
         Number(data, "/streamsFailed");
}

}  // namespace latticed
