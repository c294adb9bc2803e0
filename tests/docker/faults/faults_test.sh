#!/usr/bin/env bash
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: faults_test.sh BUILD [KIND…]
# Kills, stops, cuts off, drains and adds servers, crashes PostgreSQL and restarts the proxy while `latticectl torture` edits
# scenes. Nothing that was acknowledged may be lost or count twice. Prints the pauses of the edits for each kind of fault.
# It makes one fault of each kind with few scenes, as CI does. LATTICED_STORE_FAULTS=10 makes all (counts below), which takes
# half an hour; 1 makes a tenth.
# It needs root, for namespaces of the network, and skips (77) without it or without HAProxy or PostgreSQL. It fails
# instead if LATTICED_REQUIRE_NAMESPACES, LATTICED_REQUIRE_HAPROXY or LATTICED_REQUIRE_POSTGRES is set.
set -euo pipefail
missing() {  # VALUE_THAT_FORBIDS_IT WHAT
  echo "skipped, missing: $2"
  [[ -z $1 ]] || exit 1
  exit 77
}
PATH=$PATH:/usr/sbin:$(compgen -G '/usr/lib/postgresql/*/bin' | sort -V | tail -n 1)
for program in haproxy curl openssl python3 initdb ip unshare nsenter setpriv; do
  command -v "$program" >/dev/null || missing "${LATTICED_REQUIRE_HAPROXY:-}${LATTICED_REQUIRE_POSTGRES:-}" "$program"
done
if [[ -z ${LATTICED_FAULTS_NETWORK:-} ]]; then
  unshare --net ip link add test type bridge 2>/dev/null && ((EUID == 0)) ||
    missing "${LATTICED_REQUIRE_NAMESPACES:-}" "the right to make a namespace of the network"
  LATTICED_FAULTS_NETWORK=own exec unshare --net "$0" "$@"
fi

build=$(readlink -f "$1")
shift
export PATH=$build/client/cpp:$PATH
tenths=${LATTICED_STORE_FAULTS:-0}
most_pause_ms=10000 scenes=60 stand_still=10 cut=10 settle=1.5 moments=10
((tenths > 0)) || { scenes=6 stand_still=1 cut=4 settle=0.3 moments=3; }
source "$(dirname "${BASH_SOURCE[0]}")/cluster.sh"

# How many faults of so many.
part_of() { local part=$(($1 * tenths / 10)); echo $((part > 0 ? part : 1)); }
a_moment() { sleep "0.$((RANDOM % moments))$((RANDOM % 10))"; }

# Each makes one fault, and returns when the next may come.
back_again() { start "$1"; until_true is_ready "$1"; }
kill_solo() { a_moment; murder solo; back_again solo; }
kill_any() { local names=(a b c) victim; victim=${names[RANDOM % 3]}; a_moment; murder "$victim"; back_again "$victim"; }
kill_fullest() { local victim; victim=$(most_scenes a b c); a_moment; murder "$victim"; sleep "$settle"; back_again "$victim"; }
stop_fullest() {
  local victim
  victim=$(most_scenes a b c)
  kill -STOP "${pids[$victim]}"
  sleep "$stand_still"
  kill -CONT "${pids[$victim]}"
  until_true is_ready "$victim"
  sleep "$settle"
}
cut_fullest() {
  local victim
  victim=$(most_scenes a b c)
  cut_off "$victim"
  sleep "$cut"
  # What the proxy still sends would be sent again seconds after the server is back, and new calls on that connection with it.
  # It is given up after two seconds, and calls came until the proxy knew.
  for _ in {1..60}; do sends_nothing_to "$victim" && break; sleep 0.05; done
  sends_nothing_to "$victim" || fail "the proxy keeps connections with unsent bytes to $victim"
  put_back "$victim"
  until_true is_ready "$victim"
  sleep "$settle"
}
drain_fullest() { local victim; victim=$(most_scenes a b c); a_moment; drain "$victim"; back_again "$victim"; }
add_server() { back_again d; sleep "$settle"; drain d; }
crash_postgres() {
  a_moment
  kill -QUIT "${pids[postgres]}"
  wait "${pids[postgres]}" || true
  start_postgres
  until_true is_ready a
  sleep "$settle"
}
restart_proxy() { a_moment; kill "${pids[proxy]}"; wait "${pids[proxy]}" || true; start_proxy; sleep "$settle"; }

# Reads torture.json: edits acknowledged, and pauses in ms.
figures() {
  python3 -c 'import json
report = json.load(open("torture.json"))
pauses, answers = report["pauses"], report["answers"]
print(report["acknowledged"], round(pauses["p50Ms"]), round(pauses["p99Ms"]), round(answers["maxMs"]))'
}
torture() {  # TEXT COUNT FAULT: edits until COUNT faults were made
  local text=$1 count fault=$3 server=(--server localhost:443 --tls-ca ca.pem) names=(a b c) status=0
  local before acknowledged p50 p99 longest
  count=$(part_of "$2")
  if [[ $fault == kill_solo ]]; then
    server=(--server "${address[solo]}:50151") names=(solo)
    back_again solo
  fi
  before=$(applied "${names[@]}")
  latticectl torture --json --scenes "$scenes" --seconds 100000 "${server[@]}" >torture.json 2>torture.txt &
  pids[torture]=$!
  until_true has_applied "$((before + 2 * scenes))" "${names[@]}"
  for ((n = 0; n < count; ++n)); do
    "$fault"
    kill -0 "${pids[torture]}" 2>/dev/null || break
  done
  kill -TERM "${pids[torture]}" 2>/dev/null || true
  wait "${pids[torture]}" || status=$?
  ((status == 128 + 15)) || { cat torture.json; fail "$text: torture ended with $status"; }
  read -r acknowledged p50 p99 longest < <(figures)
  echo "| $text | $count | $acknowledged | $p50 | $p99 | $longest |"
  ((longest < most_pause_ms)) || fail "$text: a pause was too long"
}

make_cluster
echo "| $scenes scenes; fault | how many | edits acknowledged | pauses, p50, ms | p99 | longest |"
echo "|---|---|---|---|---|---|"
wanted=" ${*:-kill_solo kill_any kill_fullest stop_fullest cut_fullest drain_fullest add_server crash_postgres restart_proxy} "
run() { [[ $wanted != *" $3 "* ]] || torture "$@"; }
run "one server with SQLite killed" 200 kill_solo
run "one of three servers killed" 200 kill_any
run "the server with most scenes killed" 50 kill_fullest
run "it stands still for $stand_still s" 20 stop_fullest
run "it is cut off for $cut s" 20 cut_fullest
run "it drains" 20 drain_fullest
run "a server added, and drained again" 10 add_server
run "PostgreSQL crashes" 10 crash_postgres
run "HAProxy starts again" 5 restart_proxy
echo "0 edits lost, doubled or acknowledged twice; no gaps; all lattices as acknowledged"
