// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The viewer's files, requests of other sites' pages, downloads, and the operator's port.
#include <gmock/gmock.h>

#include <cstring>
#include <filesystem>
#include <thread>

#include "server/web/admin_pages.h"
#include "tests/server/support/raw_call.h"
#include "tests/server/web/web_fixture.h"
#include "tests/support/becomes.h"

namespace latticed::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

TEST_F(WebTest, ServesTheViewerAsAPageThatTrustsNobody) {
  Serve();

  const WebAnswer page = Get("/");

  EXPECT_EQ(page.status, 200);
  EXPECT_EQ(page.body, "<!doctype html>viewer");
  EXPECT_EQ(page.fields.at("content-type"), "text/html; charset=utf-8");
  EXPECT_EQ(page.fields.at("x-content-type-options"), "nosniff");
  EXPECT_THAT(page.fields.at("content-security-policy"),
              HasSubstr("script-src 'self' 'wasm-unsafe-eval'"));
}

TEST_F(WebTest, FilesHaveTheirMediaTypes) {
  folder_.Write("web/app.js", "let a");
  folder_.Write("web/draco/decoder.wasm", "asm");
  folder_.Write("web/style.css", "body{}");
  folder_.Write("web/a b.svg", "<svg/>");
  folder_.Write("web/session.webp", "RIFF");
  folder_.Write("web/unknown.bin", "?");
  Serve();

  EXPECT_EQ(Get("/app.js").fields.at("content-type"), "text/javascript; charset=utf-8");
  EXPECT_EQ(Get("/draco/decoder.wasm?v=1").fields.at("content-type"), "application/wasm");
  EXPECT_EQ(Get("/style.css").fields.at("content-type"), "text/css; charset=utf-8");
  EXPECT_EQ(Get("/a%20b.svg").fields.at("content-type"), "image/svg+xml");
  EXPECT_EQ(Get("/session.webp").fields.at("content-type"), "image/webp");
  EXPECT_EQ(Get("/unknown.bin").fields.at("content-type"), "application/octet-stream");
}

TEST_F(WebTest, AFileThatTheBrowserHasIsNotSentAgain) {
  folder_.Write("web/app.js", "one");
  Serve();
  WebClient client(http());

  const WebAnswer first = client.Get("/app.js");
  const std::string etag = first.fields.at("etag");
  const WebAnswer second = client.Get("/app.js", {{"if-none-match", "\"other\", " + etag}});
  folder_.Write("web/app.js", "another");
  const WebAnswer third = client.Get("/app.js", {{"if-none-match", etag}});

  EXPECT_EQ(first.fields.at("cache-control"), "no-cache");
  EXPECT_EQ(second.status, 304);
  EXPECT_EQ(second.body, "");
  EXPECT_EQ(third.status, 200);
  EXPECT_EQ(third.body, "another");
}

TEST_F(WebTest, HeadTellsTheSizeWithoutTheFile) {
  Serve();
  WebClient client(http());

  const WebAnswer head = client.Ask("HEAD", "/");

  EXPECT_EQ(head.status, 200);
  EXPECT_EQ(head.fields.at("content-length"), "21");
  EXPECT_EQ(client.Get("/").body.size(), 21) << "the connection goes on";
}

TEST_F(WebTest, ALargeFileComesWhole) {
  std::string bytes(3'000'001, 'x');
  bytes[2'999'999] = 'y';
  folder_.Write("web/large.bin", bytes);
  Serve();

  EXPECT_TRUE(Get("/large.bin").body == bytes);
}

TEST_F(WebTest, NothingOutsideOfTheFolderIsServed) {
  folder_.Write("secret", "secret");
  folder_.Write("web/.hidden", "secret");
  std::filesystem::create_symlink(folder_.path() / "secret", folder_.path() / "web/link");
  Serve();

  for (const std::string target :
       {"/../secret", "/%2e%2e/secret", "/..%2fsecret", "/a/../../secret", "/.hidden", "/link",
        "/%2e%2e%5csecret", "/index.html%00", "/%zz", "//etc/passwd", "/nothing", "/link/"}) {
    const WebAnswer answer = Get(target);
    EXPECT_EQ(answer.status, 404) << target;
    EXPECT_THAT(answer.body, Not(HasSubstr("secret"))) << target;
  }
}

TEST_F(WebTest, WithoutAViewerThePageSaysSo) {
  std::filesystem::remove(folder_.path() / "web/index.html");
  Serve();

  const WebAnswer page = Get("/");

  EXPECT_EQ(page.status, 404);
  EXPECT_THAT(page.body, HasSubstr("--web-root"));
}

TEST_F(WebTest, OtherMethodsAreRefusedWithWhatIsAllowed) {
  Serve();

  const WebAnswer answer = WebClient(http()).Ask("DELETE", "/index.html");

  EXPECT_EQ(answer.status, 405);
  EXPECT_EQ(answer.fields.at("allow"), "GET, HEAD");
}

// DNS rebinding: the attacker's host name resolves to this server's address.
TEST_F(WebTest, RefusesAHostThatIsNotItsOwn) {
  options_.allowed_hosts = {"viewer.example"};
  Serve();

  const WebAnswer refused = Get("/", {{"host", "evil.example:8080"}});

  EXPECT_EQ(refused.status, 403);
  EXPECT_THAT(refused.body, HasSubstr("--allowed-hosts"));
  EXPECT_EQ(Call("latticed.v1.ServerService/GetServerInfo", Frame(""), {{"host", "evil.example"}})
                .http.status,
            403);
  for (const std::string host : {"localhost", "127.0.0.1:1", "[::1]:8080", "Viewer.Example:443"}) {
    EXPECT_EQ(Get("/", {{"host", host}}).status, 200) << host;
  }
  EXPECT_EQ(Get("/", {{"host", "192.0.2.1"}}).status, 403);
}

TEST_F(WebTest, RefusesAPageOfAnotherSite) {
  Serve();
  const std::string info = "latticed.v1.ServerService/GetServerInfo";

  const GrpcWebAnswer refused = Call(info, Frame(""), {{"origin", "https://evil.example"}});

  EXPECT_EQ(refused.http.status, 403);
  EXPECT_THAT(refused.http.body, HasSubstr("--cors-origin"));
  EXPECT_EQ(refused.http.fields.count("access-control-allow-origin"), 0);
  EXPECT_EQ(Call(info, Frame(""), {{"origin", "null"}}).http.status, 403);
  EXPECT_EQ(Call(info, Frame(""), {{"origin", "http://localhost:1"}}).http.status, 403);
  EXPECT_EQ(Call(info, Frame(""), {{"origin", "http://localhost"}}).code, 0);
  EXPECT_EQ(Get("/", {{"sec-fetch-site", "cross-site"}, {"sec-fetch-mode", "no-cors"}}).status,
            403);
  EXPECT_EQ(Get("/", {{"sec-fetch-site", "cross-site"}, {"sec-fetch-mode", "navigate"}}).status,
            200);
  EXPECT_EQ(Get("/", {{"sec-fetch-site", "same-origin"}, {"sec-fetch-mode", "cors"}}).status, 200);
}

TEST_F(WebTest, APageOfAConfiguredSiteMayCallAndRead) {
  options_.cors_origins = {"https://app.example"};
  Serve();
  const WebFields page = {{"origin", "https://app.example"}};

  WebFields asking = page;
  asking["access-control-request-method"] = "POST";
  asking["access-control-request-headers"] = "authorization,content-type,grpc-timeout";
  const WebAnswer preflight =
      WebClient(http()).Ask("OPTIONS", "/latticed.v1.ServerService/GetServerInfo", asking);
  const GrpcWebAnswer call = Call("latticed.v1.ServerService/GetServerInfo", Frame(""), page);
  asking["origin"] = "https://evil.example";

  EXPECT_EQ(preflight.status, 204);
  EXPECT_EQ(preflight.fields.at("access-control-allow-origin"), "https://app.example");
  EXPECT_EQ(preflight.fields.at("access-control-allow-headers"),
            "authorization,content-type,grpc-timeout");
  EXPECT_EQ(call.code, 0);
  EXPECT_EQ(call.http.fields.at("access-control-allow-origin"), "https://app.example");
  EXPECT_EQ(call.http.fields.at("vary"), "origin");
  EXPECT_THAT(call.http.fields.at("access-control-expose-headers"),
              HasSubstr("latticed-request-id"));
  EXPECT_EQ(WebClient(http()).Ask("OPTIONS", "/x", asking).status, 403);
}

TEST_F(WebTest, DownloadsAnExport) {
  ServeScene();

  const WebAnswer file =
      Get(fmt::format("/export/{}.ply", kScene), {{"latticed-request-id", "download-1"}});

  EXPECT_EQ(file.status, 200);
  EXPECT_THAT(file.body, StartsWith("ply\n"));
  EXPECT_EQ(file.fields.at("content-length"), fmt::to_string(file.body.size()));
  EXPECT_THAT(file.fields.at("content-disposition"), StartsWith("attachment; filename=\""));
  EXPECT_EQ(file.fields.at("latticed-request-id"), "download-1");
  EXPECT_EQ(file.fields.at("latticed-node"), "test-node");
  for (const std::string format : {"obj", "stl", "glb", "drc", "nets"}) {
    const WebAnswer other = Get(fmt::format("/export/{}.{}", kScene, format));
    EXPECT_EQ(other.status, 200) << format;
    EXPECT_GT(other.body.size(), 100) << format;
  }
}

TEST_F(WebTlsTest, DownloadsOverTlsWhatTheStubExports) {
  ServeScene();
  auto request = For<v1::ExportRequest>();
  request.set_format(v1::EXPORT_FORMAT_PLY);
  request.mutable_view()->set_segments(32);
  const std::string native = Export(request).value();

  WebClient client(http(), folder_.Path("server.crt"));
  const WebAnswer file = client.Get(fmt::format("/export/{}.ply?segments=32", kScene));

  EXPECT_EQ(file.status, 200);
  EXPECT_GT(native.size(), size_t{1} << 20) << "many records of TLS";
  EXPECT_TRUE(file.body == native);
}

TEST_F(WebTest, DownloadsAnExportWithTheSegmentsAndNormalsAskedFor) {
  ServeScene();
  const auto triangles = [this](const std::string& query) {
    const WebAnswer file = Get(fmt::format("/export/{}.stl{}", kScene, query));
    EXPECT_EQ(file.status, 200) << file.body;
    uint32_t count = 0;
    std::memcpy(&count, file.body.substr(80, 4).data(), 4);
    return count;
  };
  const auto ply = [this](const std::string& query) {
    return Get(fmt::format("/export/{}.ply?{}", kScene, query)).body;
  };

  const uint32_t patches = triangles("?segments=1");

  EXPECT_EQ(triangles("?normals=facet&segments=3"), 9 * patches);
  EXPECT_EQ(triangles("?segments=%33%32"), 1024 * patches) << "32, escaped";
  EXPECT_EQ(triangles(""), 16 * patches) << "the scene's default view";
  EXPECT_THAT(ply("normals=smooth&segments=1"), HasSubstr("property float nx"));
  EXPECT_THAT(ply("normals=none&segments=1"), Not(HasSubstr("property float nx")));
  EXPECT_EQ(triangles("?tolerance=0.01"), patches) << "a patch at rest is flat";
  EXPECT_EQ(triangles("?geometry=exact&segments=1"), patches);
  EXPECT_EQ(triangles("?geometry=original&segments=3"), 2u * 8 * 8);
}

TEST_F(WebTest, ADownloadByAToleranceTellsItsCertifiedError) {
  options_.cors_origins = {"https://app.example"};
  ServeScene();
  ASSERT_OK(Apply(MoveOne("editor", 1, 13, {0.5, 0, 0})));
  auto request = For<v1::ExportRequest>();
  request.set_format(v1::EXPORT_FORMAT_PLY);
  request.mutable_view()->set_tolerance(0.01);
  std::vector<v1::ExportResponse> parts;
  ASSERT_OK(ReadAll(&Scenes::Export, request, &parts));
  const double certified = parts.front().header().certified_error();
  const auto fields = [this](const std::string& query) {
    return Get(fmt::format("/export/{}.ply{}", kScene, query), {{"origin", "https://app.example"}})
        .fields;
  };

  const WebFields file = fields("?tolerance=0.01");

  ASSERT_GT(certified, 0);
  EXPECT_EQ(std::stod(file.at("latticed-certified-error")), certified);
  EXPECT_THAT(file.at("access-control-expose-headers"), HasSubstr("latticed-certified-error"));
  EXPECT_EQ(fields("").count("latticed-certified-error"), 0) << "without a tolerance";
}

TEST_F(WebTest, AQueryOfADownloadThatMeansNothingIsRefused) {
  ServeScene();
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"segments=0", "segments: got '0', allowed is 1 to 32"},
      {"segments=33", "segments: got '33', allowed is 1 to 32"},
      {"segments=4.5", "segments: got '4.5', allowed is 1 to 32"},
      {"segments=99999999999", "allowed is 1 to 32"},
      {"segments=", "segments: got '', allowed is 1 to 32"},
      {"tolerance=0", "tolerance: got '0', allowed are numbers above 0, in world units"},
      {"tolerance=-1e-3", "tolerance: got '-1e-3'"},
      {"tolerance=inf", "tolerance: got 'inf'"},
      {"tolerance=0.1mm", "tolerance: got '0.1mm'"},
      {"tolerance=1e-12", "view.tolerance: got 1e-12"},
      {"normals=rough", "normals: got 'rough', allowed are none, facet, smooth"},
      {"segments", "query: 'segments' has no value that can be read"},
      {"segments=%zz", "query: 'segments=%zz' has no value that can be read"},
      {"segments=4&segments=8", "query: 'segments' is given twice"},
      {"segments=4&bits=8",
       "query: 'bits' is not a parameter; known: segments, tolerance, normals, geometry"},
      {"geometry=best", "geometry: got 'best', allowed are exact, patches, original"}};

  for (const auto& [query, why] : cases) {
    const WebAnswer answer = Get(fmt::format("/export/{}.ply?{}", kScene, query));
    EXPECT_EQ(answer.status, 400) << query;
    EXPECT_THAT(answer.body, HasSubstr(why)) << query;
  }
}

TEST_F(WebTest, ADownloadThatCannotBeSaysWhy) {
  AskForTokens();
  Serve();
  const WebFields token = {{"authorization", "Bearer secret-edit"}};

  const WebAnswer no_token = Get("/export/no-such-scene.ply");
  const WebAnswer no_scene = Get("/export/no-such-scene.ply", token);
  const WebAnswer no_format = Get("/export/no-such-scene.exe", token);

  EXPECT_EQ(no_token.status, 401);
  EXPECT_EQ(no_token.fields.at("www-authenticate"), "Bearer");
  EXPECT_EQ(no_scene.status, 404);
  EXPECT_THAT(no_scene.body, HasSubstr("no-such-scene"));
  EXPECT_EQ(no_scene.fields.at("latticed-node"), "test-node");
  EXPECT_EQ(no_format.status, 404);
  EXPECT_THAT(no_format.body, HasSubstr("glb"));
}

TEST_F(WebTest, TheOperatorsPortHasHealthAndNotTheApi) {
  Serve();

  EXPECT_EQ(Admin("/healthz").status, 200);
  EXPECT_EQ(Admin("/readyz").status, 200);
  EXPECT_THAT(Admin("/metrics").body, HasSubstr("latticed_rpc_finished_total"));
  EXPECT_EQ(Admin("/").status, 404);
  EXPECT_EQ(Admin("/latticed.v1.ServerService/GetServerInfo", "POST").status, 405);
  EXPECT_EQ(WebClient(server_->admin_address()).Get("/healthz", {{"host", "evil.example"}}).status,
            403);
  EXPECT_EQ(Get("/healthz").status, 404) << "and --http has no such page";
}

TEST_F(WebTest, ReadinessEndsWithServing) {
  options_.drain_delay = absl::Seconds(5);  // long enough for a machine that stalls
  Serve();
  WebClient admin(server_->admin_address());
  ASSERT_EQ(admin.Get("/readyz").status, 200);

  std::thread drain([this] { server_->Drain(); });
  int status = 0;
  const auto ends = [&] {
    status = admin.Get("/readyz").status;
    return status != 200;
  };
  EXPECT_TRUE(Becomes(300, ends));
  const int page = Get("/").status;
  const int health = admin.Get("/healthz").status;
  const std::string grpc_health = Health(server_->channel(), "latticed.v1.SceneService");
  const absl::Status during = StreamTest::Call(&Infos::GetServerInfo, {});
  drain.join();

  EXPECT_EQ(status, 503);
  EXPECT_EQ(page, 200) << "served during the delay";
  EXPECT_EQ(health, 200) << "a restart would not help";
  EXPECT_EQ(grpc_health, "2") << "NOT_SERVING";
  EXPECT_OK(during) << "calls are served during the delay";
  EXPECT_EQ(Get("/").status, 0) << "no connection any more";
  EXPECT_THAT(StreamTest::Call(&Infos::GetServerInfo, {}),
              StatusIs(absl::StatusCode::kUnavailable));
  EXPECT_EQ(Admin("/readyz").status, 503) << "said until the end of the process";
}

TEST(AdminPagesTest, SayWhatTheirHooksSay) {
  web::AdminHooks hooks;
  absl::Status state;
  uint64_t dropped = 0;
  hooks.health = [&] { return state; };
  hooks.dropped_log_lines = [&] { return dropped; };
  hooks.ready = [] { return false; };
  hooks.metrics = [](const ConnectionCounts& http) {
    return fmt::format("latticed_scenes 1\n{} open\n", http.open);
  };

  const auto healthz = [&] {
    return web::AdminAnswer(hooks, {.method = "GET", .path = "/healthz"}, {});
  };
  EXPECT_EQ(healthz().body, "ok\n");
  dropped = 3;
  EXPECT_EQ(healthz().body, "ok; 3 lines of the log were dropped\n");
  state = absl::UnavailableError("the device is lost");
  const auto health = healthz();
  const auto metrics = web::AdminAnswer(hooks, {.method = "GET", .path = "/metrics"}, {.open = 7});

  EXPECT_EQ(health.status, 503);
  EXPECT_EQ(health.body, "the device is lost\n");
  EXPECT_EQ(web::AdminAnswer(hooks, {.method = "GET", .path = "/readyz"}, {}).status, 503);
  EXPECT_EQ(metrics.status, 200);
  EXPECT_EQ(metrics.body, "latticed_scenes 1\n7 open\n");
  EXPECT_EQ(metrics.fields[0].value, "text/plain; version=0.0.4; charset=utf-8");
}

}  // namespace
}  // namespace latticed::testing
