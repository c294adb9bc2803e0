# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# What tests of several servers share: a folder of their own, PostgreSQL, and the proxy of docker/compose.shared.yaml. Whoever
# sources it sets `root` and defines admin_of SERVER, which prints the address of its --admin. All ends with the shell.
work=$(mktemp -d)
declare -A pids=()
end_all() {
  [[ -z ${pids[postgres]:-} ]] || kill -QUIT "${pids[postgres]}" 2>/dev/null || true  # KILL would leave its shared memory
  unset 'pids[postgres]'
  kill -KILL "${pids[@]}" 2>/dev/null || true
  wait 2>/dev/null
  rm -rf "$work"
}
trap end_all EXIT
cd "$work"
fail() { echo "failed: $*"; tail -n 20 ./*.txt; exit 1; }
until_true() { for _ in {1..1200}; do "$@" && return || sleep 0.05; done; fail "it never came true: $*"; }

# PostgreSQL does not run as root.
as_postgres=(setpriv --pdeathsig QUIT)
((EUID != 0)) || as_postgres+=(--reuid postgres --regid postgres --clear-groups)
start_postgres() {
  "${as_postgres[@]}" postgres -D database/data -k "$work/database" -c listen_addresses="$postgres_address" -c fsync=off \
    -c max_connections=200 >>postgres.txt 2>&1 &
  pids[postgres]=$!
}
make_postgres() {  # [ADDRESS]: on a Unix socket alone without one
  postgres_address=${1:-}
  ((EUID != 0)) || { chmod 711 . && install -d -o postgres database; }
  "${as_postgres[@]}" initdb -D database/data -A trust -U latticed -E UTF8 --locale C --no-sync >initdb.txt 2>&1 || fail "no database"
  [[ -z $postgres_address ]] || echo "host all all $postgres_address/24 trust" >>database/data/pg_hba.conf
  echo "host=${postgres_address:-$work/database} user=latticed dbname=postgres" >url
  start_postgres
  until_true grep -q 'ready to accept connections' postgres.txt
}

murder() {  # SERVER
  kill -KILL "${pids[$1]}"
  wait "${pids[$1]}" 2>/dev/null || true
}
metric() {  # SERVER SAMPLE
  curl -sS -m 2 "http://$(admin_of "$1")/metrics" | awk -v name="$2" '$1 == name { value = $2 } END { print value + 0 }'
}
most_scenes() {  # prints the running server with most scenes
  for name in "$@"; do echo "$(metric "$name" latticed_scenes) $name"; done | sort -n | tail -n 1 | cut -d' ' -f2
}

make_proxy() {  # ADDRESS SED_ARGUMENT…, which change docker/haproxy-servers.cfg
  openssl req -x509 -newkey rsa:2048 -nodes -days 2 -subj /CN=localhost -addext subjectAltName=DNS:localhost \
    -keyout key.pem -out ca.pem 2>/dev/null
  cat ca.pem key.pem >latticed.pem
  touch owners.map
  local part edits=(-e "s|0.0.0.0:443|$1|; s|/etc/haproxy|$work|" "${@:2}")
  for part in haproxy.cfg haproxy-shared.cfg haproxy-servers.cfg; do sed "${edits[@]}" "$root/docker/$part" >"$part"; done
}
start_proxy() {
  LATTICED_SHARED=1 haproxy -db -f haproxy.cfg -f haproxy-shared.cfg -f haproxy-servers.cfg >>haproxy.txt 2>&1 &
  pids[proxy]=$!
}
