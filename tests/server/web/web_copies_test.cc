// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Compressed copies of the viewer's files, and how long a browser keeps each file.
#include <gmock/gmock.h>

#include <filesystem>

#include "tests/server/web/web_fixture.h"

namespace latticed::testing {
namespace {

class WebCopiesTest : public WebTest {
 protected:
  void SetUp() override {
    WebTest::SetUp();
    folder_.Write("web/assets/main-2Q7DJWPX.js", "the file itself");
    folder_.Write("web/assets/main-2Q7DJWPX.js.br", "brotli");
    folder_.Write("web/assets/main-2Q7DJWPX.js.gz", "the gzip");
    folder_.Write("web/docs/index.html", "<p>a page</p>");
    folder_.Write("web/docs/index.html.gz", "gzip");
  }
  static constexpr char kMain[] = "/assets/main-2Q7DJWPX.js";
};

TEST_F(WebCopiesTest, SendsTheCopyThatTheClientLikesBest) {
  Serve();
  WebClient client(http());
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"gzip, deflate, br, zstd", "brotli"},
      {"br", "brotli"},
      {"BR", "brotli"},
      {"gzip", "the gzip"},
      {"br;q=0, gzip", "the gzip"},
      {"br;q=0.0, gzip;q=0.001", "the gzip"},
      {"br;q=0.5, gzip;q=0.8", "the gzip"},
      {"br ; Q=0.5,\tgzip ;q=0.5", "brotli"},
      {"*", "brotli"},
      {"*;q=0.5, br;q=0", "the gzip"},
      {"br;q=2, gzip", "the gzip"},
      {"br;q=nan, gzip", "the gzip"},
      {"br;x=1", "brotli"},
      {"identity;q=0, br;q=0.1", "brotli"},
      {"identity, br;q=0.5, gzip", "the gzip"},
      {"identity, br;q=0.5", "the file itself"},
      {"br;q=0", "the file itself"},
      {"*;q=0", "the file itself"},
      {"deflate, zstd", "the file itself"},
      {",;,;q=1,=", "the file itself"},
      {"", "the file itself"}};
  for (const auto& [accepted, body] : cases) {
    const WebAnswer answer = client.Get(kMain, {{"accept-encoding", accepted}});
    const auto coding = answer.fields.find("content-encoding");

    EXPECT_EQ(answer.status, 200) << accepted;
    EXPECT_EQ(answer.body, body) << accepted;
    EXPECT_EQ(coding == answer.fields.end() ? "" : coding->second,
              body == "brotli" ? "br" : (body == "the gzip" ? "gzip" : ""))
        << accepted;
    EXPECT_EQ(answer.fields.at("vary"), "accept-encoding") << accepted;
    EXPECT_EQ(answer.fields.at("content-type"), "text/javascript; charset=utf-8") << accepted;
  }
  EXPECT_EQ(client.Get(kMain).body, "the file itself");
}

TEST_F(WebCopiesTest, HeadTellsTheSizeOfTheCopy) {
  Serve();

  const WebAnswer head = WebClient(http()).Ask("HEAD", kMain, {{"accept-encoding", "gzip, br"}});

  EXPECT_EQ(head.fields.at("content-length"), "6");
  EXPECT_EQ(head.fields.at("content-encoding"), "br");
}

TEST_F(WebCopiesTest, AFileWithoutThatCopyIsSentInTheNextBest) {
  Serve();

  EXPECT_EQ(Get("/docs/", {{"accept-encoding", "br, gzip;q=0.1"}}).body, "gzip");
  EXPECT_EQ(Get("/docs/", {{"accept-encoding", "br"}}).body, "<p>a page</p>");
  EXPECT_EQ(Get("/", {{"accept-encoding", "br, gzip"}}).body, "<!doctype html>viewer");
}

TEST_F(WebCopiesTest, EachCopyHasItsOwnETag) {
  Serve();
  WebClient client(http());
  const auto ask = [&](const std::string& accepted, const std::string& etag) {
    return client.Get(kMain, {{"accept-encoding", accepted}, {"if-none-match", etag}});
  };

  const std::string etag = ask("br", "").fields.at("etag");
  const WebAnswer known = ask("br", etag);

  EXPECT_EQ(known.status, 304);
  EXPECT_EQ(known.body, "");
  EXPECT_EQ(known.fields.at("etag"), etag);
  EXPECT_EQ(known.fields.at("vary"), "accept-encoding");
  EXPECT_EQ(ask("gzip", etag).body, "the gzip");
  EXPECT_EQ(ask("", etag).body, "the file itself");
}

TEST_F(WebCopiesTest, BrowsersKeepFilesWithAHashAndAskAgainForOthers) {
  Serve();
  WebClient client(http());
  const std::string forever = "public, max-age=31536000, immutable";

  EXPECT_EQ(client.Get(kMain).fields.at("cache-control"), forever);
  EXPECT_EQ(client.Get(kMain, {{"accept-encoding", "br"}}).fields.at("cache-control"), forever);
  EXPECT_EQ(client.Get("//%61ssets/main-2Q7DJWPX.js").fields.at("cache-control"), forever);
  EXPECT_EQ(client.Get("/").fields.at("cache-control"), "no-cache");
  EXPECT_EQ(client.Get("/docs/").fields.at("cache-control"), "no-cache");
  // A release that is not on this server yet may have it.
  const WebAnswer missing = client.Get("/assets/main-OTHER.js");
  EXPECT_EQ(missing.status, 404);
  EXPECT_EQ(missing.fields.at("cache-control"), "no-store");
}

TEST_F(WebCopiesTest, ACopyOutsideOfTheFolderIsNotSent) {
  folder_.Write("secret", "secret");
  folder_.Write("web/app.js", "app");
  std::filesystem::create_symlink(folder_.path() / "secret", folder_.path() / "web/app.js.br");
  std::filesystem::create_directory(folder_.path() / "web/app.js.gz");
  Serve();

  EXPECT_EQ(Get("/app.js", {{"accept-encoding", "br, gzip"}}).body, "app");
}

}  // namespace
}  // namespace latticed::testing
