#!/usr/bin/env bash
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: gpu_server_test.sh [FOLDER]
#
# Tests the server on a real device, with the programs in FOLDER (default: the folder of this script, an
# unpacked bundle's bin) and a small budget: device memory by purpose; eviction of scenes and their return;
# refusal of a view beyond the budget, with the bytes that it asks for and the free bytes; updates that the load
# generator verifies; the page of --http; and an update by gRPC-Web. tests/server covers these in detail with
# fake devices.
set -euo pipefail
folder=${1:-$(dirname "$(readlink -f "$0")")}
readonly most_scenes=60
work=$(mktemp -d)

"$folder/latticed" --backend cuda --gpu-memory 24MiB --listen 127.0.0.1:0 --http 127.0.0.1:0 \
  --admin 127.0.0.1:0 >"$work/log" 2>&1 &
readonly server=$!
trap 'kill "$server" 2>/dev/null; wait; rm -rf "$work"' EXIT

fail() { echo "FAILED: $*"; tail -n 20 "$work"/*log; exit 1; }

for ((i = 0; i < 300; ++i)); do
  grep -q ' serving ' "$work/log" && break
  kill -0 "$server" || fail "the server ended"
  sleep 0.1
done
grep -q ' serving ' "$work/log" || fail "the server does not serve"
said() { sed -n "s/.* serving .*\b$1=\([^ ]*\).*/\1/p" "$work/log"; }
LATTICED_SERVER=$(said address)
export LATTICED_SERVER
readonly admin=$(said admin)

ctl() { "$folder/latticectl" "$@" >"$work/ctl.log" 2>&1; }
# Prints the response, with its headers, to a request whose body is read from FILE, if given.
ask() {  # ADDRESS METHOD PATH [TYPE FILE]
  exec 3<>"/dev/tcp/${1%:*}/${1##*:}"
  printf '%s %s HTTP/1.1\r\nHost: %s\r\nConnection: close\r\n' "$2" "$3" "$1" >&3
  if (($# > 3)); then printf 'Content-Type: %s\r\nContent-Length: %d\r\n' "$4" "$(wc -c <"$5")" >&3; fi
  { printf '\r\n'; if (($# > 3)); then cat "$5"; fi; } >&3
  cat <&3
  exec 3>&-
}
metric() {  # NAME: the sum of its samples
  ask "$admin" GET /metrics | tr -d '\r' |
    awk -v name="$1" '$1 == name || index($1, name "{") == 1 { sum += $2 } END { print sum + 0 }'
}
create_and_use() {  # SCENE
  ctl scene create "$work/knot.obj" --id "$1" --segments 6 || fail "scene create $1"
  ctl export "$1" -o "$work/$1.ply" || fail "export $1"
}

ctl info --health || fail "the server is not healthy"
ctl sample knot -o "$work/knot.obj" || fail "sample"
create_and_use scene-0001
ctl scene show scene-0001 && grep -q 'bytes of device_' "$work/ctl.log" || fail "device memory is not reported"

http=$(said http)
ask "$http" GET / >"$work/page"
# A build without npm lacks the viewer. Its page then says so.
viewer='without its viewer'
[[ -e $folder/../share/latticed/viewer/index.html ]] && viewer='<script type="module"'
grep -q "$viewer" "$work/page" || fail "no page, or another than that of $viewer"
printf '\0\0\0\0\x0c\x0a\x0ascene-0001' >"$work/request"  # a frame of 12 bytes: the first field's, of 10
ask "$http" POST /latticed.v1.SceneService/GetUpdate application/grpc-web+proto "$work/request" >"$work/update"
grep -aq 'grpc-status: 0' "$work/update" || fail "no update by gRPC-Web"
(($(wc -c <"$work/update") > 100000)) || fail "an update of $(wc -c <"$work/update") bytes by gRPC-Web"
echo "an update by gRPC-Web: $(wc -c <"$work/update") bytes"

for ((i = 2; $(metric latticed_give_backs_total) == 0; ++i)); do
  ((i <= most_scenes)) || fail "no scene was moved out"
  create_and_use "$(printf 'scene-%04d' "$i")"
done
echo "a scene was moved out for number $((i - 1))"
mv "$work/scene-0001.ply" "$work/first.ply"
ctl export scene-0001 -o "$work/scene-0001.ply" || fail "export of a scene that was moved out"
cmp "$work/first.ply" "$work/scene-0001.ply" || fail "a scene that was moved out comes back another"

ctl sample knot --resolution 16 -o "$work/large.obj" || fail "sample"
if ctl scene create "$work/large.obj" --id scene-large --segments 32 &&
  ctl watch scene-large --segments 32 --updates 1; then
  fail "a view beyond the budget was not refused"
fi
grep -q OUT_OF_MEMORY "$work/ctl.log" || fail "the refusal gives another reason"
refusal='s/.*the view on device 0 needs \([0-9]*\) bytes, \([0-9]*\) are free.*/\1 \2/p'
read -r asked free < <(sed -n "$refusal" "$work/ctl.log") || fail "the refusal lacks requested and free bytes"
# At least two triangles per quad, with 561 vertices of 8 bytes each. A view needs more besides.
vertices=$((2 * $(grep -c '^f ' "$work/large.obj") * 561 * 8))
((free <= 24 << 20 && asked > vertices)) || fail "$asked bytes are asked, of vertices alone $vertices; $free are free"
echo "refused: $(tail -n 1 "$work/ctl.log")"
ctl scene delete scene-large || true

ctl bench knot --resolution 2 --size 5,5,5 --edits 20 || fail "bench"
grep -E 'verified: [1-9]' "$work/ctl.log" || fail "nothing was verified"
kill -TERM "$server"
wait "$server" || fail "the server's exit status is $?"
trap 'rm -rf "$work"' EXIT
echo "all passed"
