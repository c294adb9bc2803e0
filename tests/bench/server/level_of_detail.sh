#!/usr/bin/env bash
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# level_of_detail.sh BUILD: starts a server in its own network namespace, behind a link shaped to 100 Mbit/s. A
# watcher drags a scene of 17,119 patches there. Prints updates per second and the time to full detail, and
# fails if a limit is missed. Needs root and Debian's package iproute2.
set -euo pipefail
build=$(readlink -f "$1")
bytes_per_second=11500000  # 100 Mbit/s less 8 % for TCP/IP, HTTP/2 and the rest of the messages
space=latticed-$$ outside=lat$$ inside=lat$$i address=10.213.7
log=$(mktemp)

((EUID == 0)) || { echo "level_of_detail.sh: must be run as root" >&2; exit 2; }
finish() {
  [[ -z ${server:-} ]] || { kill "$server" && wait "$server" || true; }
  ip link del "$outside" 2>/dev/null || true
  ip netns del "$space" 2>/dev/null || true
  rm -f "$log"
}
trap finish EXIT

ip netns add "$space"
ip link add "$outside" type veth peer name "$inside" netns "$space"
ip addr add "$address.1/30" dev "$outside"
ip link set "$outside" up
ip -n "$space" addr add "$address.2/30" dev "$inside"
ip -n "$space" link set "$inside" up
ip netns exec "$space" tc qdisc add dev "$inside" root tbf rate 100mbit burst 64kb latency 50ms
ip netns exec "$space" tc qdisc show dev "$inside"

ip netns exec "$space" "$build/server/latticed" --listen "$address.2:50251" --insecure --backend cpu >"$log" 2>&1 &
server=$!
for _ in {1..100}; do
  (exec 3<>"/dev/tcp/$address.2/50251") 2>/dev/null && break
  kill -0 "$server" 2>/dev/null || { cat "$log" >&2; exit 2; }
  sleep 0.1
done
"$build/tests/bench/level_of_detail" "$address.2:50251" "$bytes_per_second"
