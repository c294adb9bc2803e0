// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/store/postgres/schema.h"

#include <array>
#include <cstdint>
#include <string>

#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed {
namespace {

// Records and snapshots are compact already: PostgreSQL need not try to compress them.
constexpr char kTables[] = R"sql(
CREATE SCHEMA IF NOT EXISTS latticed;
CREATE TABLE latticed.version(number bigint NOT NULL);
INSERT INTO latticed.version VALUES(0);
CREATE TABLE latticed.session(
  session bigint GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
  name text NOT NULL,
  lease interval NOT NULL,
  expires timestamptz NOT NULL,
  fenced boolean NOT NULL DEFAULT false,
  writer bigint NOT NULL DEFAULT 0,
  free_bytes bigint NOT NULL DEFAULT 0) WITH (fillfactor = 50);
CREATE TABLE latticed.scene(
  number bigint GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
  id bytea NOT NULL UNIQUE,
  session bigint,
  snapshot_lsn bigint NOT NULL DEFAULT 0,
  sum bigint NOT NULL,
  header bytea NOT NULL) WITH (fillfactor = 80);
CREATE TABLE latticed.snapshot(
  scene bigint PRIMARY KEY, lsn bigint NOT NULL, sum bigint NOT NULL, bytes bytea NOT NULL);
CREATE TABLE latticed.record(
  scene bigint NOT NULL, lsn bigint NOT NULL, sum bigint NOT NULL, bytes bytea NOT NULL,
  PRIMARY KEY(scene, lsn));
ALTER TABLE latticed.snapshot ALTER bytes SET STORAGE EXTERNAL;
ALTER TABLE latticed.record ALTER bytes SET STORAGE EXTERNAL;
CREATE TABLE latticed.mesh(id bytea PRIMARY KEY, sum bigint NOT NULL, header bytea NOT NULL);
)sql";

// While PostgreSQL was down, nobody could renew: all leases are good for once their length after its start.
constexpr char kFunctions[] = R"sql(
CREATE FUNCTION latticed.good_until(s latticed.session) RETURNS timestamptz LANGUAGE sql STABLE AS $$
  SELECT CASE WHEN s.fenced THEN '-infinity'
              ELSE greatest(s.expires, pg_postmaster_start_time() + s.lease) END
$$;
CREATE FUNCTION latticed.attach(me bigint) RETURNS bigint LANGUAGE plpgsql AS $$
DECLARE attached bigint;
BEGIN
  -- Waits for an append of the old connection.
  PERFORM FROM latticed.session WHERE session = me AND NOT fenced FOR UPDATE;
  UPDATE latticed.session SET writer = writer + 1 WHERE session = me AND NOT fenced
    RETURNING writer INTO attached;
  RETURN attached;
END $$;
CREATE FUNCTION latticed.claim(me bigint, claimed bytea, OUT verdict text, OUT owner text)
LANGUAGE plpgsql AS $$
DECLARE
  holder bigint;
  s latticed.session;
  remaining interval;
BEGIN
  LOOP
    IF NOT EXISTS (SELECT FROM latticed.session WHERE session = me AND NOT fenced) THEN
      verdict := 'fenced';
      RETURN;
    END IF;
    SELECT scene.session INTO holder FROM latticed.scene WHERE id = claimed;
    IF NOT FOUND THEN verdict := 'missing'; RETURN; END IF;
    IF holder = me THEN verdict := 'own'; RETURN; END IF;
    SELECT * INTO s FROM latticed.session WHERE session = holder;
    IF FOUND AND NOT s.fenced THEN
      remaining := latticed.good_until(s) - clock_timestamp();
      IF remaining <= interval '0' THEN
        -- Waits for appends under way: they hold the row by FOR KEY SHARE.
        SELECT * INTO s FROM latticed.session WHERE session = holder FOR UPDATE;
        remaining := latticed.good_until(s) - clock_timestamp();
      END IF;
      IF remaining > interval '0' THEN
        owner := s.name;
        verdict := CASE WHEN remaining > s.lease / 2 THEN 'other' ELSE 'wait' END;
        RETURN;
      END IF;
      UPDATE latticed.session SET fenced = true WHERE session = holder AND NOT fenced;
    END IF;
    UPDATE latticed.scene SET session = me
      WHERE id = claimed AND scene.session IS NOT DISTINCT FROM holder;
    IF FOUND THEN verdict := 'own'; RETURN; END IF;
  END LOOP;
END $$;
)sql";

// When the scene was released last. A server of the first version writes it too: so it is a trigger's work.
constexpr char kUsed[] = R"sql(
ALTER TABLE latticed.scene ADD COLUMN used timestamptz NOT NULL DEFAULT now();
CREATE FUNCTION latticed.note_use() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
  IF NEW.session IS NULL THEN NEW.used := clock_timestamp(); END IF;
  RETURN NEW;
END $$;
CREATE TRIGGER note_use BEFORE UPDATE OF session ON latticed.scene
  FOR EACH ROW EXECUTE FUNCTION latticed.note_use();
)sql";
// The lease of a session that is fenced while a claim waits for its row: before PostgreSQL 17 no time can be subtracted from
// -infinity, as the first version had it.
constexpr char kExpire[] = R"sql(
CREATE OR REPLACE FUNCTION latticed.good_until(s latticed.session) RETURNS timestamptz
LANGUAGE sql STABLE AS $$
  SELECT CASE WHEN s.fenced THEN 'epoch'
              ELSE greatest(s.expires, pg_postmaster_start_time() + s.lease) END
$$;
CREATE FUNCTION latticed.expire(me bigint, expired bytea, unused interval) RETURNS boolean
LANGUAGE plpgsql AS $$
DECLARE
  seen latticed.scene;
  last_use timestamptz;
BEGIN
  SELECT * INTO seen FROM latticed.scene WHERE id = expired;
  IF NOT FOUND OR seen.session = me THEN RETURN false; END IF;
  SELECT greatest(seen.used, expires) INTO last_use
    FROM latticed.session WHERE session = seen.session;
  IF coalesce(last_use, seen.used) > clock_timestamp() - unused THEN RETURN false; END IF;
  -- Fences a server that ended without a word. From here on the scene is ours.
  IF (SELECT verdict FROM latticed.claim(me, expired)) <> 'own' THEN RETURN false; END IF;
  IF NOT EXISTS (SELECT FROM latticed.scene WHERE number = seen.number AND used = seen.used) THEN
    -- Somebody has had it in between.
    UPDATE latticed.scene SET session = NULL WHERE id = expired;
    RETURN false;
  END IF;
  DELETE FROM latticed.scene WHERE number = seen.number;
  DELETE FROM latticed.snapshot WHERE scene = seen.number;
  DELETE FROM latticed.record WHERE scene = seen.number;
  RETURN true;
END $$;
)sql";

// A share goes with its scene, also where a server of an older version deletes the scene.
constexpr char kShares[] = R"sql(
CREATE TABLE latticed.share(
  id bytea PRIMARY KEY,
  number bigint GENERATED ALWAYS AS IDENTITY,
  scene bigint NOT NULL REFERENCES latticed.scene(number) ON DELETE CASCADE,
  sum bigint NOT NULL,
  header bytea NOT NULL);
CREATE INDEX ON latticed.share(scene);
)sql";

struct Upgrade {
  const char* tables;
  const char* functions;  // may be null
};
// Upgrade i leads from version i to i + 1.
constexpr std::array<Upgrade, kPostgresSchemaVersion> kUpgrades = {
    {{kTables, kFunctions}, {kUsed, kExpire}, {kShares, nullptr}}};

constexpr int64_t kUpgradeLock = 0x6C617474;  // "latt", among the database's advisory locks

// 0: there is none.
absl::StatusOr<int64_t> ReadVersion(PgConnection& connection) {
  LATTICED_ASSIGN_OR_RETURN(
      const PgRows found,
      connection.Execute("SELECT (to_regclass('latticed.version') IS NOT NULL)::int::bigint, "
                         "(SELECT count(*) FROM pg_class WHERE relnamespace = "
                         "to_regnamespace('latticed'))",
                         {}));
  if (found.Number(0, 0) == 0) {
    if (found.Number(0, 1) == 0) return 0;
    return absl::FailedPreconditionError(
        "the database has a schema 'latticed' that another program made");
  }
  LATTICED_ASSIGN_OR_RETURN(const PgRows version,
                            connection.Execute("SELECT number FROM latticed.version", {}));
  if (version.size() == 1) return version.Number(0, 0);
  return absl::FailedPreconditionError(
      "the database's schema 'latticed' does not say which version it has");
}

absl::Status UpgradeSchema(PgConnection& connection) {
  LATTICED_RETURN_IF_ERROR(
      connection.Execute("SELECT pg_advisory_xact_lock($1)", PgParameters().Number(kUpgradeLock))
          .status());
  LATTICED_ASSIGN_OR_RETURN(const int64_t version, ReadVersion(connection));
  if (version > kPostgresSchemaVersion) {
    return absl::FailedPreconditionError(fmt::format(
        "the database has schema {}, which a newer latticed made; this one reads up to {}", version,
        kPostgresSchemaVersion));
  }
  if (version == kPostgresSchemaVersion) return absl::OkStatus();
  for (auto step = static_cast<size_t>(version); step < kUpgrades.size(); ++step) {
    const auto [tables, functions] = kUpgrades[step];
    LATTICED_RETURN_IF_ERROR(connection.Execute(tables));
    if (functions != nullptr) LATTICED_RETURN_IF_ERROR(connection.Execute(functions));
  }
  return connection
      .Execute("UPDATE latticed.version SET number = $1",
               PgParameters().Number(int64_t{kPostgresSchemaVersion}))
      .status();
}

}  // namespace

absl::Status PreparePostgresSchema(PgConnection& connection) {
  LATTICED_ASSIGN_OR_RETURN(const int64_t version, ReadVersion(connection));
  if (version == kPostgresSchemaVersion) return absl::OkStatus();
  LATTICED_RETURN_IF_ERROR(connection.Execute("BEGIN"));
  const absl::Status status = UpgradeSchema(connection);
  LATTICED_RETURN_IF_ERROR(connection.Execute(status.ok() ? "COMMIT" : "ROLLBACK"));
  return status;
}

}  // namespace latticed
