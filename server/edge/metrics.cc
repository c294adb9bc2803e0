// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/edge/metrics.h"

#include <prometheus/text_serializer.h>
#include <sys/resource.h>

#include <filesystem>
#include <iterator>
#include <string>
#include <system_error>
#include <utility>

#include "fmt/format.h"
#include "server/base/engine_counts.h"
#include "server/base/process_memory.h"
#include "server/base/telemetry.h"
#include "server/edge/metric_families.h"
#include "server/rpc/access/quota_access.h"
#include "server/rpc/call_counts.h"
#include "server/rpc/server_env.h"
#include "server/rpc/services.h"
#include "server/stores/scene_registry.h"
#include "server/stores/upload_store.h"

namespace latticed {
namespace {

void AddServer(ServerEnv& env, const v1::ServerInfo& info, MetricFamilies& out) {
  const bool lost = !env.scenes->health().status().ok();
  out.Gauge("latticed_build_info", "1; what runs is in the labels.")
      .Add(1.0, {{"version", info.version()},
                 {"commit", info.commit()},
                 {"backend", info.backends(0).name()}});
  out.Gauge("latticed_device_healthy",
            "1 while the backend has its device; 0 from its loss to the next start.")
      .Add(lost ? 0.0 : 1.0);
  out.Gauge("latticed_draining", "1 once new calls are refused since the server stops.")
      .Add(env.drain.stop_requested() ? 1.0 : 0.0);
}

void AddStores(ServerEnv& env, const v1::ServerInfo& info, MetricFamilies& out) {
  size_t watchers = 0;
  const auto scenes = env.scenes->All();
  for (const auto& scene : scenes) watchers += scene->watcher_count();
  out.Gauge("latticed_scenes", "Scenes in memory.").Add(scenes.size());
  out.Gauge("latticed_watchers", "Streams that watch a scene.").Add(watchers);
  out.Gauge("latticed_meshes", "Meshes in memory.").Add(env.meshes.All().size());
  out.Gauge("latticed_uploads", "Uploads under way.").Add(env.uploads->size());
  out.Counter("latticed_give_backs_total",
              "Times that an unused scene gave memory back to make room for another.")
      .Add(info.backends(0).give_backs());
}

// Of the tenants that --quota-file names: others may be many. A store that is shared is not asked: it may not answer.
void AddTenants(ServerEnv& env, MetricFamilies& out) {
  auto quota = out.Gauge("latticed_tenant_quota", "What a tenant may have, by kind.");
  auto used = out.Gauge("latticed_tenant_used", "What it has; of a rate, within a second.");
  auto refused = out.Counter("latticed_tenant_refused_total", "Refusals for want of quota.");
  if (env.store != nullptr && env.store->shared()) return;
  const QuotaTable table = env.quotas.table();
  for (const auto& [tenant, entry] : table.named()) {
    const auto uses = QuotasOf(env, tenant);
    if (!uses.ok()) continue;  // the store does not answer, which other metrics say
    for (const QuotaInUse& use : *uses) {
      const MetricFamilies::Labels labels = {{"tenant", tenant}, {"what", QuotaName(use.kind)}};
      quota.Add(use.quota, labels);
      used.Add(use.used, labels);
      refused.Add(env.quotas.Refused(tenant, use.kind), labels);
    }
  }
}

void AddHostMemory(const v1::ServerInfo& info, MetricFamilies& out) {
  const uint64_t budget = info.limits().max_host_bytes();
  const uint64_t reserved = info.reserved_host_bytes();
  auto bytes = out.Gauge("latticed_host_memory_bytes", "Host memory in use, by purpose.");
  for (const auto& [purpose, size] : info.host_bytes()) bytes.Add(size, {{"purpose", purpose}});
  out.Gauge("latticed_host_memory_budget_bytes", "--memory.").Add(budget);
  out.Gauge("latticed_host_memory_reserved_bytes", "Bytes of the budget that are reserved.")
      .Add(reserved);
  out.Gauge("latticed_host_memory_free_bytes", "Bytes of the budget that are free.")
      .Add(budget > reserved ? budget - reserved : 0);
}

void AddDevices(const v1::ServerInfo& info, MetricFamilies& out) {
  auto bytes = out.Gauge("latticed_device_memory_bytes", "Device memory in use, by purpose.");
  auto budget =
      out.Gauge("latticed_device_memory_budget_bytes",
                "What scenes may take of a device: --gpu-memory; 0: no budget of its own.");
  auto free = out.Gauge("latticed_device_memory_free_bytes",
                        "Of the budget, or of the memory where there is none, what is free.");
  for (const v1::DeviceInfo& device : info.backends(0).devices()) {
    const std::string number = fmt::to_string(device.number());
    budget.Add(device.budget_bytes(), {{"device", number}});
    free.Add(device.free_bytes(), {{"device", number}});
    for (const auto& [purpose, size] : device.bytes()) {
      bytes.Add(size, {{"device", number}, {"purpose", purpose}});
    }
  }
}

void AddEngine(const EngineCounts& counts, MetricFamilies& out) {
  out.Counter("latticed_edits_total",
              "Batches of edits that reached a scene: applied; refused; repeated, and answered "
              "from memory.")
      .Add(counts.edits_applied, {{"result", "applied"}})
      .Add(counts.edits_refused, {{"result", "refused"}})
      .Add(counts.edits_repeated, {{"result", "repeated"}});
  out.Counter("latticed_undo_steps_forgotten_total",
              "Undo steps that scenes forgot since --memory had no room for them.")
      .Add(counts.undo_steps_forgotten);
  out.Counter("latticed_revisions_merged_total", "Revisions that a view skipped for a newer one.")
      .Add(counts.revisions_merged);
  out.Counter("latticed_evaluations_total", "Evaluations of views begun.").Add(counts.evaluations);
  out.Counter("latticed_updates_begun_total", "Updates of watchers begun.")
      .Add(counts.updates_begun);
  out.Counter("latticed_updates_finished_total", "Updates of watchers sent in full.")
      .Add(counts.updates_finished);
  out.Counter("latticed_updates_superseded_total",
              "Updates of watchers given up for a newer one in less detail.")
      .Add(counts.updates_superseded);
  out.Counter("latticed_updates_restarted_total",
              "Updates of watchers begun in place of an unfinished one.")
      .Add(counts.updates_restarted);
  out.Counter("latticed_snapshots_retired_total",
              "Snapshots dropped while a watcher was too slow to take them.")
      .Add(counts.snapshots_retired);
  out.Counter("latticed_chunk_bytes_total", "Bytes of chunks handed to gRPC.")
      .Add(counts.chunk_bytes);
  out.Histogram("latticed_stage_duration_seconds",
                "Stages of updates: evaluate and encode of every snapshot; queue, from the edit to "
                "update_begin, and send, to update_end, of every watcher.")
      .Add(counts.queue, {{"stage", "queue"}})
      .Add(counts.evaluate, {{"stage", "evaluate"}})
      .Add(counts.encode, {{"stage", "encode"}})
      .Add(counts.send, {{"stage", "send"}});
}

void AddDurability(ServerEnv& env, const v1::ServerInfo& info, MetricFamilies& out) {
  out.Gauge("latticed_durable", "1 if meshes, scenes and edits survive a restart.")
      .Add(info.durable() ? 1.0 : 0.0);
  if (env.store == nullptr) return;
  if (env.store->shared()) {
    out.Counter("latticed_leases_lost_total",
                "Times that this server did not renew its lease in time, and lost its scenes.")
        .Add(env.scenes->leases_lost());
  } else {
    out.Gauge("latticed_scenes_asleep", "Scenes that are stored and not in memory.")
        .Add(env.scenes->asleep_count());
  }
  out.Counter("latticed_scene_moves_total",
              "Scenes that were read from the store; scenes that left memory, for the store or "
              "another server.")
      .Add(env.scenes->claims(), {{"direction", "in"}})
      .Add(env.scenes->departures(), {{"direction", "out"}});
  const StoreCounts& counts = env.store->counts();
  out.Gauge("latticed_store_writable",
            "1 while the store accepts writes; 0 from a failure of its medium until it recovers.")
      .Add(counts.writable ? 1.0 : 0.0);
  out.Counter("latticed_store_failures_total",
              "Times that the medium failed, so that the store refused writes until it recovered.")
      .Add(counts.failures);
  out.Gauge("latticed_store_waiting_writes", "Records and other writes that are not answered yet.")
      .Add(counts.waiting_writes);
  out.Gauge("latticed_store_waiting_bytes", "Their bytes; edits are refused from 64 MiB on.")
      .Add(counts.waiting_bytes);
  out.Counter("latticed_store_appends_total",
              "Records of edits: stored; refused, because the store failed.")
      .Add(counts.appends_stored, {{"result", "stored"}})
      .Add(counts.appends_refused, {{"result", "refused"}});
  out.Counter("latticed_store_snapshots_total", "Snapshots of scenes: stored; failed.")
      .Add(counts.snapshots_stored, {{"result", "stored"}})
      .Add(counts.snapshots_failed, {{"result", "failed"}});
  out.Counter("latticed_store_bytes_total", "Bytes that were stored, before what a database adds.")
      .Add(counts.append_bytes, {{"kind", "record"}})
      .Add(counts.snapshot_bytes, {{"kind", "snapshot"}});
  out.Counter("latticed_store_log_bytes_total",
              "Bytes that commits wrote to the write-ahead log; a checkpoint copies them later.")
      .Add(counts.log_bytes);
  out.Counter("latticed_store_scenes_broken_total",
              "Times that a scene's record could not be written, so that the scene was read anew.")
      .Add(counts.scenes_broken);
  out.Histogram("latticed_store_commit_duration_seconds",
                "Transactions that succeeded, with waiting for the medium.")
      .Add(counts.commits, {});
}

void AddCalls(const CallCounts& calls, MetricFamilies& out) {
  auto started = out.Counter("latticed_rpc_started_total", "Calls begun.");
  auto finished = out.Counter("latticed_rpc_finished_total", "Calls ended, by status code.");
  auto duration = out.Histogram("latticed_rpc_duration_seconds",
                                "From the beginning of a call to its status; streams last as long "
                                "as their client likes.");
  for (const auto& [rpc, counts] : calls.rpcs()) {
    started.Add(counts->started, {{"method", rpc}});
    duration.Add(counts->duration, {{"method", rpc}});
    for (size_t code = 0; code < counts->finished.size(); ++code) {
      if (counts->finished[code] == 0) continue;
      const auto name = absl::StatusCodeToString(static_cast<absl::StatusCode>(code));
      finished.Add(counts->finished[code], {{"method", rpc}, {"code", name}});
    }
  }
}

void AddRefusals(const CallCounts& calls, MetricFamilies& out) {
  auto refusals =
      out.Counter("latticed_refusals_total",
                  "Calls and edits refused, by ErrorReason; OUT_OF_MEMORY: by a budget.");
  for (const auto& [reason, count] : calls.refusals()) refusals.Add(count, {{"reason", reason}});
}

void AddConnections(const ConnectionCounts& grpc, const ConnectionCounts& http,
                    MetricFamilies& out) {
  auto open = out.Gauge("latticed_connections", "Connections, by port.");
  auto most = out.Gauge("latticed_connections_limit", "Most connections, by port.");
  auto refused = out.Counter("latticed_connections_refused_total",
                             "Connections refused because the limit was reached, by port.");
  for (const auto& [port, counts] : {std::pair("grpc", grpc), std::pair("http", http)}) {
    if (counts.most == 0) continue;
    open.Add(counts.open, {{"port", port}});
    most.Add(counts.most, {{"port", port}});
    refused.Add(counts.refused, {{"port", port}});
  }
}

double Seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

// The number of entries of a folder of /proc; 0 if it cannot be read.
uint64_t CountEntries(const char* folder) {
  std::error_code none;
  const std::filesystem::directory_iterator entries(folder, none);
  return static_cast<uint64_t>(std::distance(begin(entries), end(entries)));
}

// Adds metrics of the process, with the names that Prometheus's client libraries use.
void AddProcess(absl::Time start_time, MetricFamilies& out) {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  rlimit files{};
  getrlimit(RLIMIT_NOFILE, &files);
  const ProcessMemory memory = MeasureMemory();
  out.Counter("process_cpu_seconds_total", "Processor time, user and system.")
      .Add(Seconds(usage.ru_utime) + Seconds(usage.ru_stime));
  out.Gauge("process_start_time_seconds", "Start of the server since the epoch.")
      .Add(absl::ToDoubleSeconds(start_time - absl::UnixEpoch()));
  out.Gauge("process_resident_memory_bytes", "Resident memory.").Add(memory.resident_bytes);
  out.Gauge("process_virtual_memory_bytes", "Virtual memory.").Add(memory.virtual_bytes);
  out.Gauge("process_open_fds", "Open file descriptors.").Add(CountEntries("/proc/self/fd"));
  out.Gauge("process_max_fds", "Most file descriptors.").Add(uint64_t{files.rlim_cur});
  out.Gauge("process_threads", "Threads.").Add(CountEntries("/proc/self/task"));
}

}  // namespace

std::string MetricsText(ServerEnv& env, const ConnectionCounts& grpc,
                        const ConnectionCounts& http) {
  const v1::ServerInfo info = DescribeServer(env);
  MetricFamilies families;
  AddServer(env, info, families);
  AddStores(env, info, families);
  AddTenants(env, families);
  AddHostMemory(info, families);
  AddDevices(info, families);
  AddEngine(env.scenes->counts(), families);
  AddDurability(env, info, families);
  AddConnections(grpc, http, families);
  families
      .Counter("latticed_log_lines_dropped_total",
               "Log lines dropped, because nobody read them in time.")
      .Add(DroppedLogLines());
  AddCalls(*env.calls, families);
  AddRefusals(*env.calls, families);
  AddProcess(env.start_time, families);
  return prometheus::TextSerializer().Serialize(std::move(families).Take());
}

}  // namespace latticed
