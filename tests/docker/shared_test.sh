#!/usr/bin/env bash
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: shared_test.sh BUILD
# Three servers of BUILD share a PostgreSQL, behind the proxy of docker/compose.shared.yaml, with addresses of this
# machine. Every call must reach the server that has the scene, also after servers are killed, drain and come back, and
# after the proxy has forgotten what it learnt. No edit may be lost or count twice. Without HAProxy or PostgreSQL it
# skips (77), or fails if LATTICED_REQUIRE_HAPROXY or LATTICED_REQUIRE_POSTGRES is set.
set -euo pipefail
root=$(cd "$(dirname "$(readlink -f "$0")")/../.." && pwd)
build=$(readlink -f "$1")
scenes=12 most_pause_ms=3000
PATH=$PATH:/usr/sbin:$(compgen -G '/usr/lib/postgresql/*/bin' | sort -V | tail -n 1)
for program in haproxy curl openssl initdb; do
  command -v "$program" >/dev/null && continue
  echo "skipped, missing: $program"
  [[ -n ${LATTICED_REQUIRE_HAPROXY:-}${LATTICED_REQUIRE_POSTGRES:-} ]] && exit 1
  exit 77
done
source "$root/tests/docker/cluster_parts.sh"
admin_of() { echo "127.0.0.1:${ports[$1admin]}"; }
make_postgres

# The ports of a server stay the same when it starts again.
first_port=21480
free() { ! (exec 3<>"/dev/tcp/127.0.0.1/$1") 2>/dev/null; }
declare -A ports=()
for name in a b c proxy; do
  for what in address http admin; do
    until free "$first_port"; do ((++first_port)); done
    ports[$name$what]=$((first_port++))
  done
done
start() {  # SERVER
  "$build/server/latticed" --backend cpu --threads 1 --store postgres --store-url-file url --mesh-store meshes --advertise "$1" \
    --listen "127.0.0.1:${ports[$1address]}" --http "127.0.0.1:${ports[$1http]}" --admin "127.0.0.1:${ports[$1admin]}" >>"$1.txt" 2>&1 &
  pids[$1]=$!
}
for name in a b c; do start "$name"; done

edits=()
for name in a b c; do
  edits+=(-e "/ $name:50151/s/port 9090/port ${ports[${name}admin]}/; s/ $name:50151/ 127.0.0.1:${ports[${name}address]}/")
  edits+=(-e "/ $name:8080/s/port 9090/port ${ports[${name}admin]}/; s/ $name:8080/ 127.0.0.1:${ports[${name}http]}/")
done
make_proxy "127.0.0.1:${ports[proxyaddress]}" "${edits[@]}"
start_proxy

export PATH=$build/client/cpp:$PATH
ask=(--server "localhost:${ports[proxyaddress]}" --tls-ca ca.pem)
until_true latticectl info --health --retry-for 0 "${ask[@]}" >/dev/null 2>&1
edit_all() {  # REVISION: moves a control point of every scene, which then has this revision
  local n begun took longest=0
  for ((n = 1; n <= scenes; ++n)); do
    begun=$(date +%s%3N)
    latticectl edit move "scene-$n" --point 0,0,0 --by 0,0,1 "${ask[@]}" >edit.txt 2>&1 || { cat edit.txt; fail "scene-$n took no edit"; }
    took=$(($(date +%s%3N) - begun))
    ((took > longest)) && longest=$took
    grep -q "^revision $1:" edit.txt || { cat edit.txt; fail "scene-$n is not at revision $1"; }
  done
  echo "revision $1 of $scenes scenes, $2: the longest call took $longest ms"
  ((longest < most_pause_ms)) || fail "that is too long"
}

latticectl sample vase --resolution 1 -o vase.obj >/dev/null
for ((n = 1; n <= scenes; ++n)); do
  latticectl scene create vase.obj --id "scene-$n" "${ask[@]}" >create.txt 2>&1 || { cat create.txt; fail "scene-$n was not made"; }
done
for name in a b c; do (($(metric "$name" latticed_scenes) > 0)) || fail "server $name has no scenes"; done
edit_all 1 "on three servers"

killed=$(most_scenes a b c)
murder "$killed"
edit_all 2 "after a kill of $killed"
start "$killed"
until_true latticectl info --health --retry-for 0 --server "127.0.0.1:${ports[${killed}address]}" >/dev/null 2>&1
edit_all 3 "with $killed back"

drained=$(most_scenes a b c)
kill -TERM "${pids[$drained]}"
edit_all 4 "while $drained drains"
kill "${pids[proxy]}"
wait "${pids[proxy]}" || true
start_proxy
edit_all 5 "after the proxy forgot all owners"

# The owner dies in the middle of a drag. The client's next stream sends again what was not answered.
steps=300 applied='latticed_edits_total{result="applied"}'
others=(a b c)
for name in "${!others[@]}"; do [[ ${others[name]} == "$drained" ]] && unset "others[name]"; done
declare -A before=()
for name in "${others[@]}"; do before[$name]=$(metric "$name" "$applied"); done
latticectl quickstart "${ask[@]}" --sample knot --steps "$steps" --output dragged >drag.txt 2>&1 &
drag=$!
dragged=
for _ in {1..600}; do
  for name in "${others[@]}"; do (($(metric "$name" "$applied") > before[$name] + 5)) && dragged=$name; done
  [[ -n $dragged ]] && break || sleep 0.1
done
[[ -n $dragged ]] || fail "no edits came"
murder "$dragged"
wait "$drag" || { cat drag.txt; fail "a drag did not go on"; }
latticectl scene list "${ask[@]}" | awk -v steps="$steps" '/knot/ && $5 == steps { found = 1 } END { exit !found }' ||
  { latticectl scene list "${ask[@]}"; fail "the drag has not $steps revisions"; }
echo "shared: every edit counts once, whoever dies"
