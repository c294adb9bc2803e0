# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# Three servers of BUILD that share a PostgreSQL, "a", "b" and "c", and "d" for later, behind the proxy of
# docker/compose.shared.yaml, in the network namespace of the shell: each server has one of its own on a bridge, so that it
# can be cut off. And "solo", with SQLite, without a proxy. All ends with the shell.
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../../.." && pwd)
source "$root/tests/docker/cluster_parts.sh"
declare -A address=() arguments=()
admin_of() { echo "${address[$1]}:9090"; }

readonly gateway=10.0.0.1
make_network() {
  ip link set lo up
  ip link add bridge type bridge
  ip address add "$gateway/24" dev bridge
  ip link set bridge up
}
has_own_network() { [[ $(readlink "/proc/$1/ns/net") != "$(readlink /proc/self/ns/net)" ]]; }
make_host() {  # SERVER NUMBER: its network, which a sleeping process holds
  unshare --net sleep infinity &
  pids[net-$1]=$! address[$1]=10.0.0.$((10 + $2))
  until_true has_own_network "${pids[net-$1]}"
  ip link add "to-$1" type veth peer name eth0 netns "${pids[net-$1]}"
  ip link set "to-$1" master bridge up
  nsenter -t "${pids[net-$1]}" --net sh -c "ip link set lo up; ip address add ${address[$1]}/24 dev eth0; ip link set eth0 up"
}
# Nothing reaches the server, and nothing of it arrives; no side is told.
cut_off() { ip link set "to-$1" nomaster; }
sends_nothing_to() {  # SERVER: that is cut off
  ! ss -tnH state established dst "${address[$1]}" | awk '$2 > 0 { found = 1 } END { exit !found }'
}
put_back() { ip link set "to-$1" master bridge; }

start() {  # SERVER
  # shellcheck disable=SC2086  # the arguments are words
  nsenter -t "${pids[net-$1]}" --net "$build/server/latticed" --backend cpu --threads 1 --insecure \
    --listen "${address[$1]}:50151" --http "${address[$1]}:8080" --admin "${address[$1]}:9090" ${arguments[$1]} >>"$1.txt" 2>&1 &
  pids[$1]=$!
}
is_ready() { curl -sSf -m 1 "http://$(admin_of "$1")/readyz" >/dev/null 2>&1; }
drain() {  # SERVER
  kill -TERM "${pids[$1]}"
  wait "${pids[$1]}" || fail "$1 did not drain"
}
applied() {  # SERVER…: how many edits these servers have applied
  for name in "$@"; do metric "$name" 'latticed_edits_total{result="applied"}'; done | awk '{ sum += $1 } END { print sum + 0 }'
}
has_applied() {  # COUNT SERVER…
  (($(applied "${@:2}") > $1))
}

make_cluster() {
  make_network
  make_postgres "$gateway"
  local name number=0 edits
  for name in a b c d solo; do
    make_host "$name" "$((++number))"
    arguments[$name]="--store postgres --store-url-file url --mesh-store meshes --advertise $name"
  done
  arguments[solo]="--data-dir solo-data"
  for name in a b c; do start "$name"; done
  for name in a b c; do edits+=(-e "s/ $name $name:/ $name ${address[$name]}:/"); done
  # All editors have one address here.
  edits+=(-e 's/sc0_conn_cur gt 128/sc0_conn_cur gt 1024/')
  # The fourth server is as the third. sed prints a line as it is by then.
  edits+=(-e "/^  server c /{p; s/ c ${address[c]}:/ d ${address[d]}:/}")
  make_proxy 127.0.0.1:443 "${edits[@]}"
  start_proxy
  for name in a b c; do until_true is_ready "$name"; done
}
