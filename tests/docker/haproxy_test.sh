#!/usr/bin/env bash
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: haproxy_test.sh BUILD
# Runs docker/haproxy.cfg, with addresses of this machine, in front of two servers of BUILD. Every kind of call must
# reach the server that its host name selects. Clients must resume streams that a proxy cuts. Honest clients must get
# their answers despite hostile ones (attacks.py). Without HAProxy it skips (77), or fails if LATTICED_REQUIRE_HAPROXY
# is set.
set -euo pipefail
root=$(cd "$(dirname "$(readlink -f "$0")")/../.." && pwd)
build=$(readlink -f "$1")
PATH=$PATH:/usr/sbin  # Debian installs HAProxy there
for program in haproxy curl openssl python3; do
  command -v "$program" >/dev/null && continue
  echo "skipped, missing: $program"
  [[ -n ${LATTICED_REQUIRE_HAPROXY:-} ]] && exit 1
  exit 77
done
work=$build/haproxy
rm -rf "$work"
mkdir -p "$work"
cd "$work"
pids=()
trap 'kill "${pids[@]}" 2>/dev/null; wait' EXIT
fail() { echo "$*"; tail -n 20 ./*.txt; exit 1; }

# Prints the host:port on which the server NODE serves WHAT: `address`, `http` or `admin`.
listened() { sed -n "s/.* serving .*\b$2=\(127\.0\.0\.1:[0-9]*\).*/\1/p" "$1.txt"; }  # NODE WHAT
for node in a b; do
  "$build/server/latticed" --backend cpu --node "$node" --listen 127.0.0.1:0 --http 127.0.0.1:0 \
    --admin 127.0.0.1:0 --drain-delay 0s --heartbeat-interval 10s >"$node.txt" 2>&1 &
  pids+=($!)
done
for node in a b; do
  for _ in {1..600}; do [[ -n $(listened "$node" address) ]] && break || sleep 0.1; done
done

# One certificate for both names of this machine, localhost and 127.0.0.1.
openssl req -x509 -newkey rsa:2048 -nodes -days 2 -subj /CN=localhost -addext subjectAltName=DNS:localhost,IP:127.0.0.1 \
  -keyout key.pem -out ca.pem 2>/dev/null
cat ca.pem key.pem >latticed.pem

port=20480  # below the ephemeral ports
while (exec 3<>"/dev/tcp/127.0.0.1/$port") 2>/dev/null; do ((++port)); done
# Host name 127.0.0.1 selects the second server, any other the first. Timeouts of 2 s, not 10 s, shorten attacks.py.
edits=(-e "s|0.0.0.0:443|127.0.0.1:$port|; s|/etc/haproxy|$work|; s|^#2 ||; s|^  #2|  |; s|second.example.org|127.0.0.1|"
  -e 's/\(timeout http-request\|wait-for-body time\) 10s/\1 2s/')
for node in a:latticed b:second; do
  place=${node#*:} node=${node%:*} admin=$(listened "${node%:*}" admin)
  edits+=(-e "/ $place:/s|port 9090|port ${admin#*:}|"
    -e "s|$place:50151|$(listened "$node" address)|; s|$place:8080|$(listened "$node" http)|")
done
sed "${edits[@]}" "$root/docker/haproxy.cfg" >haproxy.cfg
haproxy -c -f haproxy.cfg >check.txt 2>&1 || fail "HAProxy does not take it"
haproxy -db -f haproxy.cfg >haproxy.txt 2>&1 &
pids+=($!)
# A second proxy cuts streams before their heartbeats come, and logs that.
cut_port=$((port + 100))
while (exec 3<>"/dev/tcp/127.0.0.1/$cut_port") 2>/dev/null; do ((++cut_port)); done
sed "s/127.0.0.1:$port/127.0.0.1:$cut_port/; s/60s/2s/; /^defaults/a\  log stdout format raw local0\n  option httplog" \
  haproxy.cfg >cutting.cfg
haproxy -db -f cutting.cfg >cutting.txt 2>&1 &
pids+=($!)

export PATH=$build/client/cpp:$PATH
for _ in {1..600}; do latticectl info --health --server "localhost:$port" --tls-ca ca.pem >/dev/null 2>&1 && break || sleep 0.1; done
for name in a:localhost b:127.0.0.1; do
  node=${name%:*} server=${name#*:}:$port
  latticectl info --json --server "$server" --tls-ca ca.pem | grep -q "\"node\": *\"$node\"" || fail "gRPC at $server is not $node"
  for version in --http1.1 --http2; do
    printf '\0\0\0\0\0' | curl -sS "$version" --cacert ca.pem -D - -o answer -H 'content-type: application/grpc-web+proto' \
      --data-binary @- "https://$server/latticed.v1.ServerService/GetServerInfo" >head.txt || fail "no gRPC-Web at $server"
    grep -qi "^latticed-node: $node" head.txt && grep -qa 'grpc-status: 0' answer || fail "gRPC-Web at $server is not $node's"
  done
  # The handshake of RFC 6455's example. After it, curl waits for data until --max-time.
  rm -f socket.head.txt
  for seconds in 1 30; do
    curl -sS --http1.1 --max-time "$seconds" --cacert ca.pem -o socket.txt -D socket.head.txt -H 'connection: upgrade' \
      -H 'upgrade: websocket' -H 'sec-websocket-version: 13' -H 'sec-websocket-key: dGhlIHNhbXBsZSBub25jZQ==' \
      -H "origin: https://$server" "https://$server/ws/latticed.v1.SceneService/Deform" 2>/dev/null || true
    grep -qs '101 Switching Protocols' socket.head.txt && break
  done
  grep -qs '101 Switching Protocols' socket.head.txt || fail "no WebSocket at $server"
done
latticectl quickstart --server "localhost:$port" --tls-ca ca.pem --sample knot --steps 3 --output quickstart

# The proxy refuses longer headers than the servers accept. The servers accept all headers that the proxy lets through.
times() { printf "$1%.0s" $(seq "$2"); }  # TEXT TIMES
ask=(--server "localhost:$port" --tls-ca ca.pem)
latticectl info "${ask[@]}" --token "$(times y 4700)" >/dev/null || fail "a token of 4,700 bytes is too long"
latticectl info "${ask[@]}" --token "$(times y 7000)" >long.txt 2>&1 && fail "a token of 7,000 bytes is not too long"
grep -q 'headers are too long' long.txt || fail "of a token of 7,000 bytes nobody says that it is too long"
latticectl info "${ask[@]}" --token "$(times y, 70)" >/dev/null || fail "a list of 70 in one field is too long"
call_with() {  # NUMBER of extra fields, options of curl; a client refused while it sends a body may not get the reason
  local fields=() n
  for ((n = 0; n < $1; ++n)); do fields+=(-H "x-$n: y"); done
  curl -sS --http2 --cacert ca.pem -D head.txt -o answer -H 'content-type: application/grpc' -H 'te: trailers' \
    "${fields[@]}" "${@:2}" "https://localhost:$port/latticed.v1.ServerService/GetServerInfo"
}
printf '\0\0\0\0\0' >body
call_with 50 --data-binary @body
grep -qi '^grpc-status: 0' head.txt || fail "50 fields more are too many"
call_with 70 -X POST
grep -qi '^grpc-status: 3' head.txt && grep -qi '^content-type: application/grpc' head.txt || fail "70 fields more are not too many"

# A client resumes a stream that the proxy cuts. HAProxy logs the side that timed out (c, s) and the phase (D: data).
metric() {  # SAMPLE, of the server a
  curl -sS "http://$(listened a admin)/metrics" | awk -v name="$1" '$1 == name { value = $2 } END { print value + 0 }'
}
was_cut() { grep -Eq " [cs]D[^ ]* .*SceneService/$1 " cutting.txt; }
until_true() { for _ in {1..600}; do "$@" && return || sleep 0.1; done; return 1; }
exceeds() { (($(metric "$1") > $2)); }  # METRIC NUMBER
ask=(--server "localhost:$cut_port" --tls-ca ca.pem)
watches='latticed_rpc_started_total{method="SceneService/Watch"}'
latticectl sample vase --resolution 1 -o vase.obj
latticectl scene create vase.obj --id a-scene-that-is-cut "${ask[@]}"
latticectl watch a-scene-that-is-cut --json "${ask[@]}" >watch.txt 2>&1 &
pids+=($!)
until_true was_cut Watch || fail "HAProxy cut no watch"
until_true exceeds "$watches" 1 || fail "a watch that was cut did not begin again"
latticectl edit move a-scene-that-is-cut --point 0,0,0 --by 0,0,1 "${ask[@]}"
until_true grep -q '"revision": *1' watch.txt || fail "a watch that the proxy had cut did not see the edit"

# HAProxy 2.6 replaces the status of a stream that ends before its client has half-closed.
PYTHONPATH=$root/tests/support python3 "$root/tests/docker/farewells.py" "$port" ca.pem || fail "a refusal got lost"

# Hostile clients; some of them are slow readers that watch the scene.
PYTHONPATH=$root/tests/support \
  python3 "$root/tests/docker/attacks.py" "$port" "$cut_port" ca.pem "$(listened a admin)" a-scene-that-is-cut ||
  fail "a hostile client had its way"

# A server stops in the middle of a drag. The proxy cuts the stream, and the client opens another and sends unanswered
# edits again. Each edit must be applied once.
steps=200 applied='latticed_edits_total{result="applied"}'
before=$(metric "$applied")
latticectl quickstart "${ask[@]}" --sample knot --steps "$steps" --output cut >drag.txt 2>&1 &
drag=$!
pids+=("$drag")
until_true exceeds "$applied" "$((before + 5))" || fail "no edits came"
kill -STOP "${pids[0]}"
until_true was_cut Deform || { kill -CONT "${pids[0]}"; fail "HAProxy did not cut the stream of edits"; }
kill -CONT "${pids[0]}"
wait "$drag" || fail "a stream of edits that the proxy had cut did not go on"
edits=$(($(metric "$applied") - before))
((edits == steps)) || fail "$steps edits count as $edits"
echo "haproxy: calls go to the server of the name, what is cut goes on, and hostile clients are in nobody's way"
