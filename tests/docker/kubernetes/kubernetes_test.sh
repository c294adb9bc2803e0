#!/usr/bin/env bash
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: kubernetes_test.sh BUILD
# Checks docker/kubernetes without a cluster: the manifests by types and schemas of Kubernetes, the options of the servers
# by the program, the proxies' configuration by HAProxy. Without npm or HAProxy it skips (77), or fails if
# LATTICED_REQUIRE_HAPROXY is set.
set -euo pipefail
here=$(cd "$(dirname "$(readlink -f "$0")")" && pwd)
docker=$here/../../../docker
build=$(readlink -f "$1")
PATH=$PATH:/usr/sbin
for program in npm haproxy openssl; do
  command -v "$program" >/dev/null && continue
  echo "skipped, missing: $program"
  [[ -n ${LATTICED_REQUIRE_HAPROXY:-} ]] && exit 1
  exit 77
done
work=$build/kubernetes
mkdir -p "$work" && cd "$work"
cp "$here"/{package.json,package-lock.json,check.mjs} .
npm ci --ignore-scripts --no-fund --no-audit --silent --prefer-offline
node check.mjs "$docker/kubernetes" "$work/objects"

# The servers: every variable is an option that takes the value.
variables=$(node -e '
  const { parseAllDocuments } = require("yaml");
  const text = require("node:fs").readFileSync(process.argv[1], "utf8");
  const set = parseAllDocuments(text).map((d) => d.toJS()).find(({ kind }) => kind === "StatefulSet");
  for (const { name, value } of set.spec.template.spec.containers[0].env) console.log(`${name}=${value ?? "latticed-0"}`);
' "$docker/kubernetes/base/servers.yaml")
mapfile -t variables <<<"$variables"
config=$(env "${variables[@]}" "$build/server/latticed" --token-file tokens --print-config)
for variable in "${variables[@]}"; do
  name=${variable%%=*}
  option=$(tr '[:upper:]_' '[:lower:]-' <<<"${name#LATTICED_}")
  grep -q "^$option *=" <<<"$config" || { echo "$name is no option"; exit 1; }
done

# The proxies: as they are mounted, the certificate and its key in two files.
rm -rf proxy && mkdir -p proxy/latticed.pem && cd proxy
openssl req -x509 -newkey rsa:2048 -nodes -days 2 -subj /CN=localhost -keyout latticed.pem/site.pem.key \
  -out latticed.pem/site.pem 2>/dev/null
touch owners.map
for part in "$docker"/{haproxy,haproxy-shared,kubernetes/base/haproxy-servers}.cfg; do sed "s|/etc/haproxy|$PWD|" "$part" >"$(basename "$part")"; done
LATTICED_SHARED=1 haproxy -c -q -f haproxy.cfg -f haproxy-shared.cfg -f haproxy-servers.cfg && echo "HAProxy takes its configuration"
