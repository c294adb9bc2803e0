// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Counts the HTTP answers that are not complete, so that a fuzzer knows whether it is worth to wait for more.
//
// Threads  one
#ifndef LATTICED_TESTS_FUZZ_OPEN_ANSWERS_H_
#define LATTICED_TESTS_FUZZ_OPEN_ANSWERS_H_

#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "server/web/http_exchange.h"

namespace latticed::fuzz {

class OpenAnswers {
 public:
  // The exchange, whose answer counts until it is complete. A WebSocket counts until Clear.
  std::shared_ptr<web::HttpExchange> Follow(std::shared_ptr<web::HttpExchange> exchange) {
    ++*open_;
    return std::make_shared<Followed>(std::move(exchange), open_);
  }
  bool any() const { return *open_ > 0; }
  void Clear() { open_ = std::make_shared<int>(0); }

 private:
  class Followed final : public web::HttpExchange {
   public:
    Followed(std::shared_ptr<web::HttpExchange> exchange, std::shared_ptr<int> open)
        : exchange_(std::move(exchange)), open_(std::move(open)) {}
    const web::HttpRequest& request() const override { return exchange_->request(); }
    void Post(std::function<void()> work) override { exchange_->Post(std::move(work)); }
    void Read(std::function<void(std::string_view)> done) override {
      exchange_->Read(std::move(done));
    }
    void Reply(web::HttpResponse response) override {
      --*open_;
      exchange_->Reply(std::move(response));
    }
    void Start(int status, web::HttpFields fields, std::optional<uint64_t> length) override {
      exchange_->Start(status, std::move(fields), length);
    }
    void Write(web::OutBytes bytes, std::function<void()> done) override {
      exchange_->Write(std::move(bytes), std::move(done));
    }
    void End() override {
      --*open_;
      exchange_->End();
    }
    void Abort() override {
      --*open_;
      exchange_->Abort();
    }
    void Upgrade(const std::function<void(web::Upgraded)>& take) override {
      exchange_->Upgrade(take);
    }
    void OnGone(std::function<void()> gone) override { exchange_->OnGone(std::move(gone)); }

   private:
    const std::shared_ptr<web::HttpExchange> exchange_;
    const std::shared_ptr<int> open_;
  };

  std::shared_ptr<int> open_ = std::make_shared<int>(0);
};

}  // namespace latticed::fuzz

#endif  // LATTICED_TESTS_FUZZ_OPEN_ANSWERS_H_
