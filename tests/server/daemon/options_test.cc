// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/base/options.h"

#include <cstdlib>
#include <vector>

#include "tests/support/status_matchers.h"
#include "tests/support/temporary_folder.h"

namespace latticed::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

absl::StatusOr<CommandLine> Parse(std::vector<const char*> arguments) {
  arguments.insert(arguments.begin(), "latticed");
  return ParseCommandLine(static_cast<int>(arguments.size()), arguments.data());
}

// Sets an environment variable for one test.
class Variable {
 public:
  Variable(const char* name, const char* value) : name_(name) { setenv(name, value, 1); }
  ~Variable() { unsetenv(name_); }

 private:
  const char* name_;
};

TEST(OptionsTest, DefaultsAreLoopbackAndAuto) {
  const auto parsed = Parse({});

  ASSERT_OK(parsed);
  EXPECT_EQ(parsed->options.listen, "127.0.0.1:50151");
  EXPECT_EQ(parsed->options.backend, "auto");
  EXPECT_EQ(parsed->options.heartbeat_interval, absl::Milliseconds(600));
  EXPECT_FALSE(parsed->text.has_value());
}

TEST(OptionsTest, FlagsReadUnits) {
  const auto parsed = Parse({"--memory", "3GiB", "--max-mesh-bytes=5MB", "--transport-memory=64MiB",
                             "--drain-delay", "250ms", "--backend", "cpu", "--threads", "2",
                             "--max-connections=500", "--first-message-timeout=5s"});

  ASSERT_OK(parsed);
  EXPECT_EQ(parsed->options.memory_bytes, 3'221'225'472u);
  EXPECT_EQ(parsed->options.max_mesh_bytes, 5'242'880u);
  EXPECT_EQ(parsed->options.transport_memory_bytes, 67'108'864u);
  EXPECT_EQ(parsed->options.drain_delay, absl::Milliseconds(250));
  EXPECT_EQ(parsed->options.threads, 2);
  EXPECT_EQ(parsed->options.max_connections, 500);
  EXPECT_EQ(parsed->options.first_message_timeout, absl::Seconds(5));
}

TEST(OptionsTest, EnvironmentStandsInForFlags) {
  const Variable listen("LATTICED_LISTEN", "127.0.0.1:1234");
  const Variable insecure("LATTICED_INSECURE", "true");

  const auto parsed = Parse({});

  ASSERT_OK(parsed);
  EXPECT_EQ(parsed->options.listen, "127.0.0.1:1234");
  EXPECT_TRUE(parsed->options.insecure);
}

TEST(OptionsTest, DevicesAreAListThatAFlagReplaces) {
  const Variable devices("LATTICED_DEVICES", "3");

  const auto parsed = Parse({"--devices", "0,2", "--gpu-memory", "16GiB"});

  ASSERT_OK(parsed);
  EXPECT_EQ(parsed->options.devices, (std::vector<int>{0, 2}));
  EXPECT_EQ(parsed->options.gpu_memory_bytes, uint64_t{16} << 30);
  EXPECT_EQ(Parse({})->options.devices, std::vector<int>{3});
  for (const char* wrong : {"", "0,0", "-1", "1,,2", "all"}) {
    EXPECT_THAT(Parse({"--devices", wrong}), StatusIs(absl::StatusCode::kInvalidArgument)) << wrong;
  }
}

TEST(OptionsTest, SpanPatchesIsAboveZero) {
  EXPECT_EQ(Parse({})->options.span_patches, 1'000'000u);
  EXPECT_EQ(Parse({"--span-patches", "250000"})->options.span_patches, 250'000u);
  EXPECT_THAT(Parse({"--span-patches", "0"}), StatusIs(absl::StatusCode::kInvalidArgument));
}

TEST(OptionsTest, FlagBeatsEnvironmentBeatsFile) {
  const TemporaryFolder folder;
  const std::string path =
      folder.Write("latticed.toml", "threads = 1\nbackend = \"cpu\"\nlog-level = \"debug\"\n");
  const Variable threads("LATTICED_THREADS", "2");
  const Variable backend("LATTICED_BACKEND", "auto");

  const auto parsed = Parse({"--config", path.c_str(), "--threads=3"});

  ASSERT_OK(parsed);
  EXPECT_EQ(parsed->options.threads, 3);
  EXPECT_EQ(parsed->options.backend, "auto");
  EXPECT_EQ(parsed->options.log_level, "debug");
}

TEST(OptionsTest, PrintedConfigReadsBack) {
  const auto printed = Parse({"--memory=1GiB", "--heartbeat-interval=3s", "--print-config"});
  ASSERT_OK(printed);
  ASSERT_TRUE(printed->text.has_value());
  const TemporaryFolder folder;
  const std::string path = folder.Write("latticed.toml", *printed->text);

  const auto parsed = Parse({"--config", path.c_str()});

  ASSERT_OK(parsed);
  EXPECT_EQ(parsed->options.memory_bytes, 1'073'741'824u);
  EXPECT_EQ(parsed->options.heartbeat_interval, absl::Seconds(3));
  EXPECT_THAT(parsed->options.allowed_hosts, ::testing::IsEmpty());
}

TEST(OptionsTest, HelpAndVersionArePrinted) {
  EXPECT_THAT(Parse({"--help"})->text.value(), HasSubstr("LATTICED_LISTEN"));
  EXPECT_THAT(Parse({"--version"})->text.value(), HasSubstr("latticed 0."));
}

TEST(OptionsTest, OpenPortNeedsTlsTokensOrInsecure) {
  EXPECT_THAT(Parse({"--listen=0.0.0.0:50151"}),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("--insecure")));
  EXPECT_THAT(Parse({"--listen=127.evil.example:1"}), StatusIs(absl::StatusCode::kInvalidArgument));
  EXPECT_OK(Parse({"--listen=0.0.0.0:50151", "--insecure"}));
  EXPECT_OK(Parse({"--listen=0.0.0.0:50151", "--token-file=tokens"}));
  EXPECT_OK(Parse({"--listen=0.0.0.0:50151", "--tls-cert=c", "--tls-key=k"}));
  EXPECT_OK(Parse({"--listen=[::1]:50151"}));
}

TEST(OptionsTest, ListsMayRepeatAndReplaceTheEnvironments) {
  const Variable variable("LATTICED_CORS_ORIGIN", "https://environment.example");

  const auto from_environment = Parse({});
  const auto from_flags = Parse({"--cors-origin", "https://a.example",
                                 "--cors-origin=https://b.example", "--allowed-hosts", "one,two"});
  const TemporaryFolder folder;
  const std::string path = folder.Write("latticed.toml", "allowed-hosts = [\"three\", \"four\"]\n");
  const auto from_file = Parse({"--config", path.c_str()});

  ASSERT_OK(from_environment);
  ASSERT_OK(from_flags);
  ASSERT_OK(from_file);
  EXPECT_THAT(from_environment->options.cors_origins, ElementsAre("https://environment.example"));
  EXPECT_THAT(from_flags->options.cors_origins,
              ElementsAre("https://a.example", "https://b.example"));
  EXPECT_THAT(from_flags->options.allowed_hosts, ElementsAre("one", "two"));
  EXPECT_THAT(from_file->options.allowed_hosts, ElementsAre("three", "four"));
}

TEST(OptionsTest, HttpIsOffUnlessGivenAndChecked) {
  EXPECT_EQ(Parse({})->options.http, "");
  EXPECT_EQ(Parse({})->options.admin, "");
  EXPECT_OK(Parse({"--http", "[::1]:8080", "--admin", "0.0.0.0:9090"}));
  EXPECT_OK(Parse({"--http", "0.0.0.0:8080", "--insecure"}));
  EXPECT_OK(Parse({"--http", "0.0.0.0:8080", "--token-file", "tokens"}));
  EXPECT_THAT(
      Parse({"--http", "0.0.0.0:8080"}),
      StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("--http: '0.0.0.0:8080' is open")));
  for (const char* bad : {"8080", ":8080", "localhost:http", "unix:/tmp/x", "localhost:70000"}) {
    EXPECT_THAT(Parse({"--http", bad}),
                StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("--http")))
        << bad;
  }
  for (const char* bad : {"*", "app.example", "https://app.example/", "https://"}) {
    EXPECT_THAT(Parse({"--cors-origin", bad}),
                StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("--cors-origin")))
        << bad;
  }
}

TEST(OptionsTest, ASharedStoreNeedsAllItsParts) {
  const char* const url = "--store-url-file=u";
  const char* const meshes = "--mesh-store=m";
  const char* const name = "--advertise=host-1:50151";
  const auto parsed = Parse({"--store=postgres", url, meshes, name, "--lease=2s"});
  ASSERT_OK(parsed);
  EXPECT_EQ(parsed->options.store_url_file, "u");
  EXPECT_EQ(parsed->options.mesh_store, "m");
  EXPECT_EQ(parsed->options.advertise, "host-1:50151");
  EXPECT_EQ(parsed->options.lease, absl::Seconds(2));
  EXPECT_EQ(Parse({})->options.store, "sqlite");
  EXPECT_EQ(Parse({})->options.lease, absl::Milliseconds(800));

  const auto refused = [](std::initializer_list<const char*> flags, const char* says) {
    EXPECT_THAT(Parse(flags), StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr(says)));
  };
  refused({"--store=postgres", meshes, name}, "needs --store-url-file");
  refused({"--store=postgres", url, name}, "needs --mesh-store");
  refused({"--store=postgres", url, meshes, name, "--s3-endpoint=https://host"},
          "is for --mesh-store s3://BUCKET");
  refused({"--store=postgres", url, meshes}, "needs --advertise");
  refused({"--store=postgres", url, meshes, name, "--data-dir=d"}, "--data-dir is for");
  refused({url}, "--store-url-file is for --store postgres");
  refused({"--store=redis"}, "--store");
  refused({"--store=postgres", url, meshes, "--advertise=a b"}, "--advertise: got 'a b'");
  refused({"--lease=100ms"}, "--lease: got 100ms, allowed is 200ms to 1m");
}

TEST(OptionsTest, BadValuesAreRefusedByName) {
  const auto refused = [](const char* flag, const char* named) {
    EXPECT_THAT(Parse({flag}), StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr(named)));
  };
  refused("--backend=metal", "--backend");
  refused("--threads=-1", "--threads");
  refused("--memory=0", "--memory");
  refused("--memory=lots", "--memory");
  refused("--transport-memory=15MiB",
          "--transport-memory: got 15728640, allowed is 16777216 or more");
  refused("--max-connections=-1", "--max-connections");
  refused("--first-message-timeout=1ms", "--first-message-timeout");
  refused("--max-mesh-bytes=5TB", "--max-mesh-bytes");
  refused("--heartbeat-interval=soon", "--heartbeat-interval");
  refused("--heartbeat-interval=1ms", "--heartbeat-interval");
  refused("--drain-delay=-1s", "--drain-delay");
  refused("--scene-idle-ttl=0s", "--scene-idle-ttl");
  refused("--log-format=xml", "--log-format");
  refused("--encoder=zip", "--encoder");
  refused("--listen=here", "--listen");
  refused("--tls-cert=c.pem", "--tls-key");
  refused("--tls-client-ca=ca.pem", "--tls-client-ca");
  refused("--no-such-flag", "--no-such-flag");
}

TEST(OptionsTest, UnknownKeysOfTheFileAreRefused) {
  const TemporaryFolder folder;
  const std::string path = folder.Write("latticed.toml", "lisen = \"127.0.0.1:1\"\n");

  EXPECT_THAT(Parse({"--config", path.c_str()}),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("lisen")));
}

TEST(OptionsTest, MissingFileIsRefused) {
  EXPECT_THAT(Parse({"--config", "/no/such/file.toml"}),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("/no/such/file.toml")));
}

}  // namespace
}  // namespace latticed::testing
