// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/web/http_connection.h"

#include <array>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/buffer_body.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/rfc7230.hpp>
#include <boost/beast/http/write.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <deque>
#include <limits>
#include <sstream>

#include "core/base/limits.h"
#include "fmt/format.h"
#include "server/web/http_answers.h"

namespace latticed::web {
namespace {

namespace http = beast::http;

constexpr size_t kReadBytes = size_t{64} << 10;

std::string Text(beast::string_view text) { return {text.data(), text.size()}; }

// Why a proxy and this server could take the head for two different requests (RFC 9112, 3.2 and 6.1). Empty if they
// could not.
std::string_view Ambiguity(const http::fields& head) {
  if (head.count(http::field::host) > 1) return "not a request of HTTP/1.1: more than one Host";
  const auto codings = head.count(http::field::transfer_encoding);
  if (codings == 0) return "";
  if (codings == 1 && beast::iequals(head[http::field::transfer_encoding], "chunked")) return "";
  return "not a request of HTTP/1.1: a Transfer-Encoding other than chunked";
}

class HttpConnection final : public HttpExchange,
                             public Connection,
                             public std::enable_shared_from_this<HttpConnection> {
 public:
  HttpConnection(Transport transport, std::shared_ptr<ConnectionSet::Place> place,
                 const HttpTimeouts& timeouts, const HttpHandler& handler)
      : place_(std::move(place)),
        transport_(std::move(transport)),
        executor_(transport_.get_executor()),
        timeouts_(timeouts),
        handler_(handler),
        read_(executor_),
        written_(executor_) {}

  void Begin();

  const HttpRequest& request() const override { return request_; }
  void Post(std::function<void()> work) override { net::post(executor_, std::move(work)); }
  void Read(std::function<void(std::string_view)> done) override;
  void Reply(HttpResponse response) override;
  void Start(int status, HttpFields fields, std::optional<uint64_t> length) override;
  void Write(OutBytes bytes, std::function<void()> done) override;
  void End() override;
  void Abort() override {  // of HttpExchange and of Connection
    Post([self = shared_from_this()] { self->Leave(); });
  }
  void Upgrade(const std::function<void(Upgraded)>& take) override;
  void OnGone(std::function<void()> gone) override { on_gone_ = std::move(gone); }
  void Drain() override;

 private:
  enum class State {
    kIdle,       // between requests
    kHead,       // reading the head of a request
    kAnswering,  // until the last byte of the answer is written
    kLingering,  // until the client ends too; a reset could discard the answer
    kClosed
  };
  struct Outgoing {
    OutBytes bytes;
    std::function<void()> done;
  };
  using Parser = http::request_parser<http::buffer_body>;

  void AwaitRequest();
  void Watch();
  void ReadHead();
  void OnHead(error_code failure);
  void Describe();
  void OnBodyRead(error_code failure, std::function<void(std::string_view)> done);
  void Pump();
  void Answered();
  void Linger();
  void Discard();
  void Leave();
  void Expect(net::steady_timer& timer, HttpTimeouts::Duration after);
  static void Clear(net::steady_timer& timer) {
    timer.expires_at(net::steady_timer::time_point::max());
  }

  // Destroyed last, maybe on a gRPC thread. The server waits for it before it destroys the executor.
  std::shared_ptr<ConnectionSet::Place> place_;
  Transport transport_;  // moved from after an upgrade
  const Transport::executor_type executor_;
  const HttpTimeouts timeouts_;
  const HttpHandler& handler_;
  net::steady_timer read_, written_;  // time limits for reading and writing
  beast::flat_buffer buffer_;         // bytes that were read but not parsed
  std::optional<Parser> parser_;
  HttpRequest request_;
  State state_ = State::kIdle;
  bool reading_ = false;    // a read is pending
  bool body_read_ = false;  // the whole body was read
  bool keep_alive_ = false;
  bool draining_ = false;
  bool chunked_ = false;
  bool writing_ = false;
  std::array<char, kReadBytes> body_;
  std::deque<Outgoing> outgoing_;
  std::function<void()> on_gone_;
};

void HttpConnection::Begin() {
  place_->Hold(shared_from_this());
  Post([self = shared_from_this()] {
    if (!self->transport_.secure()) return self->AwaitRequest();
    self->Expect(self->read_, self->timeouts_.head);
    self->transport_.Handshake([self](error_code failure) {
      if (failure) return self->Leave();
      self->AwaitRequest();
    });
  });
}

void HttpConnection::Expect(net::steady_timer& timer, HttpTimeouts::Duration after) {
  timer.expires_after(after);
  timer.async_wait([weak = weak_from_this(), &timer](error_code failure) {
    const auto self = weak.lock();  // keeps the timer too
    if (self == nullptr || failure) return;
    // A wait that had already ended when the time was moved has no failure, but its time has not come.
    if (timer.expiry() <= net::steady_timer::clock_type::now()) self->Leave();
  });
}

void HttpConnection::AwaitRequest() {
  if (state_ == State::kClosed) return;
  state_ = State::kIdle;
  if (draining_) return Leave();
  if (buffer_.size() > 0) return ReadHead();
  Expect(read_, timeouts_.idle);
  Watch();
}

// Waits for the first bytes of the next request, or for the end of the connection. Also runs while a
// request is being answered, to notice the end.
void HttpConnection::Watch() {
  if (reading_ || buffer_.size() > 0) return;
  reading_ = true;
  transport_.async_read_some(buffer_.prepare(limits::kMaxHttpHeadBytes),
                             [self = shared_from_this()](error_code failure, size_t bytes) {
                               self->reading_ = false;
                               if (self->state_ == State::kClosed) return;
                               if (self->state_ == State::kLingering) return self->Discard();
                               if (failure) return self->Leave();
                               self->buffer_.commit(bytes);
                               if (self->state_ == State::kIdle) self->ReadHead();
                             });
}

void HttpConnection::ReadHead() {
  state_ = State::kHead;
  body_read_ = false;
  parser_.emplace();
  parser_->header_limit(limits::kMaxHttpHeadBytes);
  // Bodies need no limit: they are read in pieces, as fast as they are used.
  parser_->body_limit(std::numeric_limits<uint64_t>::max());
  Expect(read_, timeouts_.head);
  http::async_read_header(
      transport_, buffer_, *parser_,
      [self = shared_from_this()](error_code failure, size_t) { self->OnHead(failure); });
}

void HttpConnection::OnHead(error_code failure) {
  if (state_ == State::kClosed) return;
  state_ = State::kAnswering;
  Clear(read_);
  keep_alive_ = false;
  request_ = {};
  if (failure == http::error::header_limit) {
    return Reply(TextAnswer(
        431, fmt::format("the head of a request has {} bytes at most", limits::kMaxHttpHeadBytes)));
  }
  if (failure.category() == http::make_error_code(http::error::end_of_stream).category() &&
      failure != http::error::end_of_stream && failure != http::error::partial_message) {
    return Reply(TextAnswer(400, "not a request of HTTP/1.1: " + failure.message()));
  }
  if (failure) return Leave();
  if (const auto why = Ambiguity(parser_->get()); !why.empty()) {
    return Reply(TextAnswer(400, std::string(why)));
  }
  Describe();
  body_read_ = parser_->is_done();
  // An upgrade moves the connection elsewhere, so no read may be pending.
  if (body_read_ && !request_.wants_upgrade) Watch();
  if (beast::iequals(parser_->get()[http::field::expect], "100-continue") && !body_read_) {
    writing_ = true;
    static constexpr std::string_view kContinue = "HTTP/1.1 100 Continue\r\n\r\n";
    return net::async_write(transport_, net::buffer(kContinue.data(), kContinue.size()),
                            [self = shared_from_this()](error_code broken, size_t) {
                              self->writing_ = false;
                              if (broken) return self->Leave();
                              self->handler_(self);
                            });
  }
  handler_(shared_from_this());
}

void HttpConnection::Describe() {
  const auto& head = parser_->get();
  request_.method = Text(head.method_string());
  const std::string target = Text(head.target());
  const size_t question = target.find('?');
  request_.path = target.substr(0, question);
  if (question != std::string::npos) request_.query = target.substr(question + 1);
  for (const auto& field : head) {
    std::string name = Text(field.name_string());
    for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    request_.fields.push_back({std::move(name), Text(field.value())});
  }
  request_.peer = transport_.peer();
  request_.secure = transport_.secure();
  request_.wants_upgrade = beast::websocket::is_upgrade(head);
  keep_alive_ = head.keep_alive();
}

void HttpConnection::Read(std::function<void(std::string_view)> done) {
  if (state_ == State::kClosed) return;
  if (body_read_) {
    return Post([self = shared_from_this(), done = std::move(done)] {
      if (self->state_ == State::kAnswering) done({});
    });
  }
  Expect(read_, timeouts_.body);
  parser_->get().body() = {body_.data(), body_.size(), true};
  reading_ = true;
  http::async_read_some(
      transport_, buffer_, *parser_,
      [self = shared_from_this(), done = std::move(done)](error_code failure, size_t) mutable {
        self->OnBodyRead(failure, std::move(done));
      });
}

void HttpConnection::OnBodyRead(error_code failure, std::function<void(std::string_view)> done) {
  reading_ = false;
  if (state_ == State::kLingering) return Discard();
  if (state_ != State::kAnswering) return;
  if (failure && failure != http::error::need_buffer) return Leave();
  const size_t bytes = body_.size() - parser_->get().body().size;
  body_read_ = parser_->is_done();
  if (bytes == 0 && !body_read_) return Read(std::move(done));
  Clear(read_);
  if (body_read_) Watch();
  done({body_.data(), bytes});
}

void HttpConnection::Reply(HttpResponse response) {
  const uint64_t length = response.body.size();
  Start(response.status, std::move(response.fields), length);
  if (length > 0) Write({grpc::Slice(response.body)}, [] {});
  End();
}

void HttpConnection::Start(int status, HttpFields fields, std::optional<uint64_t> length) {
  http::response_header<> head;
  head.version(11);
  head.result(static_cast<unsigned>(status));
  head.set(http::field::server, "latticed");
  for (const HttpField& field : fields) {
    if (field.name == "connection") keep_alive_ = false;  // its value is "close"
    head.insert(field.name, field.value);
  }
  // HTTP/1.0 has no chunked encoding: the end of the connection ends the body.
  const bool old = parser_->get().version() < 11;
  chunked_ = !length.has_value() && !old;
  if (chunked_) head.set(http::field::transfer_encoding, "chunked");
  if (length.has_value() && status != 204 && status != 304) {
    head.set(http::field::content_length, fmt::to_string(*length));
  }
  if (old || !body_read_ || draining_) keep_alive_ = false;
  if (!keep_alive_) head.set(http::field::connection, "close");
  std::ostringstream text;
  text << head;
  outgoing_.push_back({{grpc::Slice(text.str())}, [] {}});
  Pump();
}

void HttpConnection::Write(OutBytes bytes, std::function<void()> done) {
  if (state_ != State::kAnswering) return;
  if (request_.method == "HEAD") return Post(std::move(done));
  if (chunked_) {
    size_t size = 0;
    for (const grpc::Slice& slice : bytes) size += slice.size();
    bytes.insert(bytes.begin(), grpc::Slice(fmt::format("{:x}\r\n", size)));
    bytes.emplace_back("\r\n");
  }
  outgoing_.push_back({std::move(bytes), std::move(done)});
  Pump();
}

void HttpConnection::End() {
  if (state_ != State::kAnswering) return;
  on_gone_ = nullptr;
  OutBytes end;
  if (chunked_ && request_.method != "HEAD") end.emplace_back("0\r\n\r\n");
  outgoing_.push_back({std::move(end), [this] { Answered(); }});
  Pump();
}

// Writes the queue in order, one entry after the other: the head, then what Write and End have added.
void HttpConnection::Pump() {
  if (writing_ || outgoing_.empty()) return;
  writing_ = true;
  Expect(written_, timeouts_.write);
  net::async_write(transport_, BuffersOf(outgoing_.front().bytes),
                   [self = shared_from_this()](error_code failure, size_t) {
                     self->writing_ = false;
                     if (self->state_ != State::kAnswering) return;
                     if (failure) return self->Leave();
                     Clear(self->written_);
                     const auto done = std::move(self->outgoing_.front().done);
                     self->outgoing_.pop_front();
                     done();
                     self->Pump();
                   });
}

void HttpConnection::Answered() {
  if (!keep_alive_) return Linger();
  if (reading_) {  // the pending read is for the next request
    state_ = State::kIdle;
    if (draining_) return Leave();
    return Expect(read_, timeouts_.idle);
  }
  AwaitRequest();
}

// Shuts down sending, and discards what the client still sends.
void HttpConnection::Linger() {
  state_ = State::kLingering;
  Expect(read_, timeouts_.linger);
  transport_.Shutdown([self = shared_from_this()](error_code) {
    if (!self->reading_) self->Discard();
  });
}

void HttpConnection::Discard() {
  if (state_ == State::kClosed) return;
  reading_ = true;
  transport_.socket().async_read_some(  // below TLS, which is shut down
      net::buffer(body_), [self = shared_from_this()](error_code failure, size_t) {
        if (failure) return self->Leave();
        self->Discard();
      });
}

void HttpConnection::Upgrade(const std::function<void(Upgraded)>& take) {
  Upgraded upgraded{std::move(transport_), std::move(place_), timeouts_, {}};
  upgraded.request.base() = parser_->release().base();
  Clear(read_);
  on_gone_ = nullptr;
  state_ = State::kClosed;
  take(std::move(upgraded));
}

void HttpConnection::Drain() {
  Post([self = shared_from_this()] {
    self->draining_ = true;
    if (self->state_ == State::kIdle) self->Leave();
  });
}

void HttpConnection::Leave() {
  if (state_ == State::kClosed) return;
  state_ = State::kClosed;
  Clear(read_);
  Clear(written_);
  transport_.Close();
  outgoing_.clear();
  if (const auto gone = std::exchange(on_gone_, nullptr)) gone();
}

}  // namespace

void ServeConnection(Transport transport, std::shared_ptr<ConnectionSet::Place> place,
                     const HttpTimeouts& timeouts, const HttpHandler& handler) {
  std::make_shared<HttpConnection>(std::move(transport), std::move(place), timeouts, handler)
      ->Begin();
}

}  // namespace latticed::web
