# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# Three servers of BUILD that share a PostgreSQL, "a", "b" and "c", and "d" for later, behind the proxy of
# docker/compose.shared.yaml, in the network namespace of the shell: each server has one of its own on a bridge, so that it
# can be cut off. And "solo", with SQLite, without a proxy. All ends with the shell.
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../../.." && pwd)
work=$(mktemp -d)
declare -A pids=() address=() arguments=()
trap 'kill -KILL "${pids[@]}" 2>/dev/null || true; wait 2>/dev/null; rm -rf "$work"' EXIT
cd "$work"
fail() { echo "failed: $*"; tail -n 20 ./*.txt; exit 1; }
until_true() { for _ in {1..1200}; do "$@" && return || sleep 0.05; done; fail "it never came true: $*"; }

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
put_back() { ip link set "to-$1" master bridge; }

as_postgres=(setpriv --pdeathsig QUIT --reuid postgres --regid postgres --clear-groups)
start_postgres() {
  "${as_postgres[@]}" postgres -D database/data -k "$work/database" -c listen_addresses="$gateway" -c fsync=off \
    -c max_connections=200 >>postgres.txt 2>&1 &
  pids[postgres]=$!
}
make_postgres() {
  chmod 711 . && install -d -o postgres database
  "${as_postgres[@]}" initdb -D database/data -A trust -U latticed -E UTF8 --locale C --no-sync >initdb.txt 2>&1 || fail "no database"
  echo "host all all $gateway/24 trust" >>database/data/pg_hba.conf
  echo "host=$gateway user=latticed dbname=postgres" >url
  start_postgres
  until_true grep -q 'ready to accept connections' postgres.txt
}

start() {  # SERVER
  # shellcheck disable=SC2086  # the arguments are words
  nsenter -t "${pids[net-$1]}" --net "$build/server/latticed" --backend cpu --threads 1 --insecure --drain-delay 0s \
    --listen "${address[$1]}:50151" --http "${address[$1]}:8080" --admin "${address[$1]}:9090" ${arguments[$1]} >>"$1.txt" 2>&1 &
  pids[$1]=$!
}
is_ready() { curl -sSf -m 1 "http://${address[$1]}:9090/readyz" >/dev/null 2>&1; }
murder() {  # SERVER
  kill -KILL "${pids[$1]}"
  wait "${pids[$1]}" 2>/dev/null || true
}
drain() {  # SERVER
  kill -TERM "${pids[$1]}"
  wait "${pids[$1]}" || fail "$1 did not drain"
}
applied() {  # SERVER…: how many edits these servers have applied
  for name in "$@"; do curl -sS -m 2 "http://${address[$name]}:9090/metrics"; done |
    awk '$1 == "latticed_edits_total{result=\"applied\"}" { sum += $2 } END { print sum + 0 }'
}
has_applied() {  # COUNT SERVER…
  (($(applied "${@:2}") > $1))
}
most_scenes() {  # prints the running server with most scenes
  for name in "$@"; do
    echo "$(curl -sS -m 2 "http://${address[$name]}:9090/metrics" | awk '$1 == "latticed_scenes" { print $2 }') $name"
  done | sort -n | tail -n 1 | cut -d' ' -f2
}

make_proxy() {
  openssl req -x509 -newkey rsa:2048 -nodes -days 2 -subj /CN=localhost -addext subjectAltName=DNS:localhost \
    -keyout key.pem -out ca.pem 2>/dev/null
  cat ca.pem key.pem >latticed.pem
  touch owners.map
  local name edits=(-e "s|0.0.0.0:443|127.0.0.1:443|; s|/etc/haproxy|$work|")
  # The fourth server is as the third.
  edits+=(-e '/^  server c /{p; s/ c c:/ d d:/}')
  for name in a b c d; do edits+=(-e "s/ $name $name:/ $name ${address[$name]}:/"); done
  for part in haproxy.cfg haproxy-shared.cfg haproxy-servers.cfg; do sed "${edits[@]}" "$root/docker/$part" >"$part"; done
}
start_proxy() {
  LATTICED_SHARED=1 haproxy -db -f haproxy.cfg -f haproxy-shared.cfg -f haproxy-servers.cfg >>haproxy.txt 2>&1 &
  pids[proxy]=$!
}

make_cluster() {
  make_network
  make_postgres
  local name number=0
  for name in a b c d solo; do
    make_host "$name" "$((++number))"
    arguments[$name]="--store postgres --store-url-file url --mesh-store meshes --advertise $name"
  done
  arguments[solo]="--data-dir solo-data"
  for name in a b c; do start "$name"; done
  make_proxy
  start_proxy
  for name in a b c; do until_true is_ready "$name"; done
}
