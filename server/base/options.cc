// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/base/options.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <string_view>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"
#include "absl/strings/string_view.h"
#include "fmt/format.h"
#include "server/base/version.h"

namespace latticed {
namespace {

constexpr char kFooter[] =
    "Every option can also be set in the environment (LATTICED_LISTEN, LATTICED_MAX_MESH_BYTES, …) "
    "or in a\n"
    "TOML file given by --config (listen = \"…\", max-mesh-bytes = \"1GiB\"). Flags win over the\n"
    "environment, the environment over the file. --print-config writes such a file.";

CLI::Option* AddDuration(CLI::App& app, const std::string& name, absl::Duration& value,
                         const std::string& help) {
  const auto parse = [&value, name](const std::string& text) {
    if (!absl::ParseDuration(text, &value)) {
      throw CLI::ValidationError(
          name, fmt::format("'{}' is not a duration; write 500ms, 10s, 5m or 24h", text));
    }
  };
  return app.add_option_function<std::string>(name, parse, help)
      ->type_name("DURATION")
      ->default_str(absl::FormatDuration(value));
}

CLI::Option* AddBytes(CLI::App& app, const std::string& name, uint64_t& value,
                      const std::string& help) {
  return app.add_option(name, value, help)
      ->transform(CLI::AsSizeValue(false))
      ->type_name("BYTES")
      ->capture_default_str();
}

// Parsed as one value. A flag then replaces the environment's value; a list of CLI11's would add to it.
void AddDevices(CLI::App& app, std::vector<int>& devices) {
  const auto parse = [&devices](const std::string& text) {
    devices.clear();
    for (const absl::string_view part : absl::StrSplit(text, ',')) {
      int device = -1;
      const bool known = absl::SimpleAtoi(part, &device) && device >= 0 &&
                         std::find(devices.begin(), devices.end(), device) == devices.end();
      if (!known) {
        throw CLI::ValidationError(
            "--devices", fmt::format("'{}' is not a list of devices; write 0 or 0,1", text));
      }
      devices.push_back(device);
    }
  };
  app.add_option_function<std::string>("--devices", parse,
                                       "CUDA devices, such as 0,1; each scene goes to the freest")
      ->type_name("LIST")
      ->default_str(absl::StrJoin(devices, ","));
}

// The option may be given several times, each time with several values.
void AddList(CLI::App& app, const std::string& name, std::vector<std::string>& values,
             const std::string& help) {
  app.add_option(name, values, help)
      ->delimiter(',')
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->default_str("")  // lets --print-config write an empty list
      ->type_name("LIST");
}

// The one table of options.
void Define(CLI::App& app, Options& o) {
  app.add_option("--listen", o.listen, "Address to serve on, host:port; port 0 takes a free one");
  app.add_option("--backend", o.backend, "Where surfaces are evaluated")
      ->check(CLI::IsMember({"auto", "cpu", "cuda"}));
  app.add_option("--threads", o.threads, "Threads of the CPU backend; 0: all that are allowed")
      ->check(CLI::Range(0, 1024));
  AddDevices(app, o.devices);
  app.add_option("--span-patches", o.span_patches,
                 "A scene with at least this many patches, or too large for any one of --devices, "
                 "uses them all")
      ->check(CLI::PositiveNumber);
  AddBytes(app, "--gpu-memory", o.gpu_memory_bytes,
           "Memory of each CUDA device for scenes, such as 16GiB; 0: nine tenths of what is free");
  AddBytes(app, "--memory", o.memory_bytes,
           "Host memory for meshes, plans, views and streams, such as 4GiB; waiting requests, and "
           "replies not yet read, may each use another eighth of it");
  AddBytes(app, "--transport-memory", o.transport_memory_bytes,
           "Host memory for what gRPC buffers for all connections, beside --memory");
  app.add_option(
         "--max-connections", o.max_connections,
         "Most connections of --listen (except a Unix socket), and of --http; 0: as many as "
         "fit in --transport-memory, at 2.5 MiB each")
      ->check(CLI::Range(0, 1'000'000));
  AddBytes(app, "--max-mesh-bytes", o.max_mesh_bytes, "Largest single upload");
  app.add_option("--max-scenes", o.max_scenes, "Most scenes at a time")
      ->check(CLI::Range(1, 1'000'000));
  app.add_option("--max-watchers", o.max_watchers, "Most watchers of a scene at a time")
      ->check(CLI::Range(1, 1'000'000));
  app.add_option("--store", o.store,
                 "What keeps meshes, scenes and edits: sqlite, in --data-dir, for one server; or "
                 "postgres, which several servers share")
      ->check(CLI::IsMember({"sqlite", "postgres"}));
  app.add_option("--data-dir", o.data_dir,
                 "Folder that keeps meshes, scenes and edits; default: they end with the server");
  app.add_option("--store-url-file", o.store_url_file,
                 "File with the URL of --store postgres: postgresql://user:password@host/database");
  app.add_option(
      "--mesh-store", o.mesh_store,
      "Meshes of --store postgres: a folder that all its servers see, or s3://BUCKET/PREFIX "
      "with the keys of the environment: AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY, or "
      "AWS_SHARED_CREDENTIALS_FILE");
  app.add_option("--s3-endpoint", o.s3_endpoint,
                 "Server of that bucket, https://host:port; default: Amazon's in --s3-region");
  app.add_option("--s3-region", o.s3_region, "Region of that bucket");
  app.add_option("--advertise", o.advertise,
                 "This server's name in the proxy before the servers of --store postgres");
  AddDuration(
      app, "--lease", o.lease,
      "Time after which another server of --store postgres takes the scenes of this one, if "
      "it does not answer");
  app.add_option("--durability", o.durability,
                 "full: an edit is acknowledged when it survives a loss of power; async: when it "
                 "survives the server, so a loss of power may take the last seconds")
      ->check(CLI::IsMember({"full", "async"}));
  app.add_option("--http", o.http,
                 "Address for browsers, host:port: the viewer, gRPC-Web, WebSocket, downloads");
  app.add_option("--admin", o.admin, "Address of /healthz, /readyz and /metrics, host:port");
  AddList(app, "--allowed-hosts", o.allowed_hosts,
          "Host names accepted by --http, besides loopback's and its own");
  AddList(app, "--cors-origin", o.cors_origins,
          "Sites whose pages may use --http, such as https://app.example");
  app.add_option(
      "--web-root", o.web_root,
      "Folder of the viewer; default: viewer/ or ../share/latticed/viewer beside the program");
  app.add_option("--tls-cert", o.tls_cert, "Certificate chain, PEM");
  app.add_option("--tls-key", o.tls_key, "Private key, PEM");
  app.add_option("--tls-client-ca", o.tls_client_ca,
                 "Ask for client certificates of these CAs, PEM");
  app.add_option("--token-file", o.token_file,
                 "Bearer tokens: lines 'sha256hex role name [tenant]'");
  app.add_option("--jwks-file", o.jwks_file,
                 "Keys of JSON web tokens (RS256, ES256), JWKS; read again when replaced");
  app.add_option("--jwt-issuer", o.jwt_issuer, "The claim 'iss' that JSON web tokens must have");
  app.add_option("--jwt-audience", o.jwt_audience,
                 "The claim 'aud' that JSON web tokens must have");
  app.add_option("--quota-file", o.quota_file,
                 "What each tenant may have, JSON: server/base/quotas/quota_table.h; read again "
                 "when replaced");
  app.add_option("--audit-log", o.audit_log,
                 "Append to this file, as lines of JSON, who makes, edits and deletes what; SIGHUP "
                 "opens it again");
  app.add_option("--caller-share", o.caller_share,
                 "Largest part of each limit that one caller may have: a token's name, else an "
                 "address; 1: no limit by caller")
      ->check(CLI::Range(0.001, 1.0));
  app.add_flag("--trust-forwarded-for", o.trust_forwarded_for,
               "Take callers' addresses from x-forwarded-for; only behind a proxy that sets it");
  app.add_flag("--insecure", o.insecure, "Allow an open port without TLS or tokens");
  app.add_flag(
      "--reflection", o.reflection,
      "Answer gRPC server reflection; without this flag only if no other machine can connect");
  app.add_option("--log-level", o.log_level, "Least level to log")
      ->check(CLI::IsMember({"trace", "debug", "info", "warn", "error", "off"}));
  app.add_option("--log-format", o.log_format, "Lines for people, or JSON for machines")
      ->check(CLI::IsMember({"text", "json"}));
  AddDuration(app, "--heartbeat-interval", o.heartbeat_interval,
              "Time between heartbeats of a stream");
  AddDuration(app, "--first-message-timeout", o.first_message_timeout,
              "Time limit for the first message of a stream");
  AddDuration(app, "--write-timeout", o.write_timeout,
              "Time limit for a client to take what a call writes; then the call is cancelled");
  AddDuration(app, "--drain-delay", o.drain_delay,
              "Time from NOT_SERVING until calls are refused; none with --store postgres");
  AddDuration(app, "--drain-timeout", o.drain_timeout,
              "Time for running calls to end before they are cancelled");
  AddDuration(app, "--scene-idle-ttl", o.scene_idle_ttl, "Default idle_ttl of a scene");
  app.add_option("--encoder", o.encoder, "Writer of Draco streams: our own, or libdraco")
      ->check(CLI::IsMember({"latticed", "reference"}));
  app.add_option("--node", o.node, "This server's name in logs and metadata; default: host name");
}

// Returns the LATTICED_… variables as flags, to be put before the flags of the command line: the last value
// wins. Values of lists add up, so a list that the command line gives is left out here.
std::vector<std::string> EnvironmentFlags(const CLI::App& app,
                                          const std::vector<std::string>& given) {
  std::vector<std::string> flags;
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_lnames().empty()) continue;
    const std::string& name = option->get_lnames().front();
    if (name == "help" || name == "version" || name == "print-config") continue;
    if (option->get_multi_option_policy() == CLI::MultiOptionPolicy::TakeAll &&
        std::ranges::any_of(given, [&](const std::string& argument) {
          return argument == "--" + name || argument.rfind("--" + name + "=", 0) == 0;
        })) {
      continue;
    }
    const std::string variable =
        "LATTICED_" + absl::AsciiStrToUpper(absl::StrReplaceAll(name, {{"-", "_"}}));
    const char* value = std::getenv(variable.c_str());
    if (value != nullptr && *value != '\0') flags.push_back(fmt::format("--{}={}", name, value));
  }
  return flags;
}

}  // namespace

absl::StatusOr<CommandLine> ParseCommandLine(int argc, const char* const* argv) {
  CommandLine result;
  CLI::App app("latticed: a server for accurate free-form deformation", "latticed");
  app.option_defaults()->always_capture_default()->multi_option_policy(
      CLI::MultiOptionPolicy::TakeLast);
  Define(app, result.options);
  bool print_config = false;
  app.add_flag("--print-config", print_config, "Print the resulting config file and exit")
      ->configurable(false);
  app.set_version_flag("--version", fmt::format("latticed {} ({})", Version(), Commit()));
  app.set_config("--config", "", "TOML file of options")->configurable(false);
  app.allow_config_extras(CLI::config_extras_mode::error);
  app.footer(kFooter);

  const std::vector<std::string> given(argv + std::min(argc, 1), argv + argc);
  std::vector<std::string> arguments = EnvironmentFlags(app, given);
  arguments.insert(arguments.end(), given.begin(), given.end());
  std::reverse(arguments.begin(), arguments.end());  // CLI11 reads them from the back
  try {
    app.parse(arguments);
  } catch (const CLI::CallForHelp&) {
    result.text = app.help();
  } catch (const CLI::CallForVersion& version) {
    result.text = std::string(version.what()) + "\n";
  } catch (const CLI::ParseError& failure) {
    return absl::InvalidArgumentError(failure.what());
  }
  if (result.text.has_value()) return result;
  std::erase(result.options.allowed_hosts, "");
  std::erase(result.options.cors_origins, "");
  if (const absl::Status status = Validate(result.options); !status.ok()) return status;
  if (print_config) result.text = app.config_to_str(true, true);
  return result;
}

}  // namespace latticed
