#!/usr/bin/env bash
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: with_server.sh BUILD COMMAND…
# Starts BUILD's server on a free loopback port and runs COMMAND with its address in LATTICED_SERVER.
set -euo pipefail
build=$1
shift
log=$(mktemp)
"$build/server/latticed" --listen 127.0.0.1:0 --backend cpu --drain-delay 0s >"$log" 2>&1 &
server=$!
trap 'kill "$server" 2>/dev/null; wait "$server" || true; rm -f "$log"' EXIT
for _ in {1..600}; do
  LATTICED_SERVER=$(sed -n 's/.*serving address=\(127\.0\.0\.1:[0-9]*\).*/\1/p' "$log")
  [[ -z $LATTICED_SERVER ]] || break
  kill -0 "$server" 2>/dev/null || break
  sleep 0.1
done
[[ -n $LATTICED_SERVER ]] || { echo "no server:"; cat "$log"; exit 1; }
export LATTICED_SERVER
"$@"
