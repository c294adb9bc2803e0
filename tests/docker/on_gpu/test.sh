#!/usr/bin/env bash
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: test.sh FOLDER
# Runs the GPU image that pack.sh left in FOLDER, as root on a machine with a GPU and without a container engine. Its root
# is read-only, and its programs run as the image's user without capabilities. The devices and the driver's libraries of
# this machine are bound in, as NVIDIA's container toolkit does, and cuBLAS as well. The network is the machine's own.
#
# Tests: the image's health check, the device's name, quickstart, the load generator with and without cuBLAS, and the
# Python example where Python has gRPC. nvidia-smi and --devices agree. A server whose device is lost is NOT_SERVING, and
# its successor has the scene. Without a device the image serves on the CPU. Changes no setting of a device.
set -euo pipefail
if [[ $1 != --inside ]]; then
  [[ -f $1/root.tar.xz ]] || { echo "no $1/root.tar.xz: make it with ./dev image gpu where there is nvcc, and bring it here"; exit 1; }
  work=$(mktemp -d /var/tmp/latticed.XXXXXX)
  trap 'rm -rf --one-file-system "$work"' EXIT  # all mounts end with the namespace
  unshare --mount --pid --fork --kill-child --mount-proc bash "$0" --inside "$(readlink -f "$1")" "$work"
  exit
fi
root=$(cd "$(dirname "$(readlink -f "$0")")/../../.." && pwd)
readonly root folder=$2 work=$3 patience_s=60 server_address=127.0.0.1:50151
image=$work/root data=$work/data
fail() { echo "test.sh: $*" >&2; tail -n 30 "$work"/*.txt >&2 2>/dev/null || true; exit 1; }

mkdir "$image" "$data"
if command -v xz >/dev/null; then
  tar -xJf "$folder/root.tar.xz" --numeric-owner -C "$image"
else
  python3 -m tarfile -e "$folder/root.tar.xz" "$image"
fi
IFS=: read -r user group <"$folder/user"
mapfile -t environment <"$folder/environment"
mapfile -t health <"$folder/health"
enter=(chroot "$image" setpriv --reuid="$user" --regid="$group" --clear-groups --inh-caps=-all --bounding-set=-all
  --no-new-privs env --ignore-environment "${environment[@]}")

# bind FILE PLACE [OPTIONS]: shows this machine's FILE at PLACE of the image.
bind() {
  mkdir -p "$(dirname "$image$2")"
  touch "$image$2"
  mount --bind "$1" "$image$2"
  mount -o "remount,bind,${3:-ro}" "$image$2"
}
# Prints the folder of a library of this machine.
folder_of() {  # NAME
  local file
  file=$(ldconfig -p | awk -v name="$1" '$1 == name && !file { file = $NF } END { print file }')
  [[ -n $file ]] ||
    file=$(find /usr/local /usr/lib /opt -name "$1" -not -path '*/compat/*' -not -path '*/stubs/*' -print -quit || true)
  [[ -n $file ]] || fail "this machine has no $1"
  dirname "$file"
}

mount --bind "$image" "$image"
mount -t proc proc "$image/proc"
mount --rbind /sys "$image/sys"
mount -o remount,bind,ro "$image/sys"
mount -t tmpfs -o mode=755 tmpfs "$image/dev"
mkdir -m 1777 "$image/dev/shm"
for device in /dev/{null,zero,full,random,urandom} /dev/nvidia[0-9]* /dev/nvidiactl /dev/nvidia-uvm*; do
  [[ ! -e $device ]] || bind "$device" "$device" rw
done
chown "$user:$group" "$data"
mount --bind "$data" "$image/data"
driver=$(folder_of libcuda.so.1)
for library in "$driver"/lib{cuda,nvidia-ml,nvidia-ptxjitcompiler,nvidia-nvvm,nvidia-gpucomp}.so.*; do
  [[ ! -e $library ]] || bind "$(readlink -f "$library")" "/usr/lib/x86_64-linux-gnu/${library##*/}"
done
blas=$(folder_of libcublas.so.13)
for library in libcublas.so.13 libcublasLt.so.13; do
  bind "$(readlink -f "$blas/$library")" "/usr/local/cuda/lib64/$library"
done
bind "$(readlink -f "$(command -v nvidia-smi)")" /usr/bin/nvidia-smi
bind "$folder/lose_device.so" /srv/lose_device.so
mount -o remount,bind,ro "$image"

ctl() { "${enter[@]}" latticectl "$@" --server "$server_address"; }
# start COMMAND…: starts the server and waits for the image's health check.
start() {
  local begin=${EPOCHREALTIME/./} i
  "${enter[@]}" "$@" >>"$work/log.txt" 2>&1 &
  server=$!
  for ((i = 0; i < patience_s * 10; ++i)); do
    if "${enter[@]}" "${health[@]}" >"$work/health.txt" 2>&1; then
      echo "healthy after $(((${EPOCHREALTIME/./} - begin) / 1000)) ms: $*"
      return
    fi
    kill -0 "$server" || fail "the server ended"
    sleep 0.1
  done
  fail "not healthy after $patience_s s"
}
stop() {
  local status=0
  kill -TERM "$server"
  wait "$server" || status=$?
  ((status == 0)) || fail "the server's exit status is $status"
}
# refuse TEXT COMMAND…: the command must fail with TEXT.
refuse() {
  local text=$1
  shift
  if timeout 60 "${enter[@]}" "$@" >"$work/refused.txt" 2>&1; then fail "not refused: $*"; fi
  grep -q -- "$text" "$work/refused.txt" || fail "refused for another reason: $*"
  echo "refused: $(grep -m 1 -- "$text" "$work/refused.txt")"
}
info() { ctl info >"$work/info.txt" && grep -E '^(backend|memory of device|device lost) ' "$work/info.txt"; }

"${enter[@]}" nvidia-smi -L >"$work/devices.txt" || fail "nvidia-smi does not run in the image"
devices=$(grep -c '^GPU ' "$work/devices.txt")
query() { "${enter[@]}" nvidia-smi --query-gpu="$1" --format=csv,noheader | sed -n 1p; }
model=$(query name)
echo "nvidia-smi in the image: $devices of $model, driver $(query driver_version)"

start latticed --insecure
for line in "Uid:\s$user\s" 'CapEff:\s0+$' 'CapBnd:\s0+$' 'NoNewPrivs:\s1$'; do
  grep -qP "^$line" "/proc/$server/status" || fail "not confined, no $line in $(<"/proc/$server/status")"
done
for place in /opt/latticed /tmp /dev; do
  if "${enter[@]}" touch "$place/file" 2>/dev/null; then fail "$place is not read-only"; fi
done
echo "confined: user $user, no capabilities, a read-only root"
info
grep -q "^backend  *cuda: .*$model" "$work/info.txt" || fail "no $model"
ctl quickstart --output /data/quickstart
for pipeline in fused gemm; do  # gemm needs cuBLAS
  ctl bench knot --size 5,5,5 --edits 30 --pipeline "$pipeline" >"$work/bench.txt"
  grep -qE 'verified: [1-9]' "$work/bench.txt" || fail "$pipeline: nothing was verified"
  echo "$pipeline, $(grep -oE 'verified: .*' "$work/bench.txt")"
done
"${enter[@]}" latticectl sample vase --resolution 2 -o /data/my.obj
if python3 -c 'import google.protobuf, grpc, numpy' 2>"$work/python.txt"; then
  (cd "$data" && PYTHONPATH=$folder/python LATTICED_SERVER=$server_address python3 "$root/client/python/examples/quickstart.py")
  [[ $(head -c 4 "$data/deformed.glb") == glTF ]] || fail "the Python example left no deformed.glb"
else
  echo "NOT RUN, the Python example: $(tail -n 1 "$work/python.txt")"
fi
ctl scene create /data/my.obj --id kept >"$work/scene.txt"
ctl export kept -o /data/before.ply >"$work/export.txt"
stop

all=$(seq -s , 0 $((devices - 1)))
start latticed --insecure --backend cuda --devices "$all"
(($(info | tee /dev/stderr | grep -c '^memory of device') == devices)) || fail "nvidia-smi and latticectl info disagree"
stop
refuse "no CUDA device $devices: this machine has $devices, counted from 0" \
  latticed --insecure --backend cuda --devices "$all,$devices"

start env LD_PRELOAD=/srv/lose_device.so latticed --insecure
touch "$data/lose"
for ((i = 0; i < patience_s * 10; ++i)); do
  ! grep -q lose_device: "$work/log.txt" || break
  sleep 0.1
done
grep lose_device: "$work/log.txt"
refuse DEVICE_LOST latticectl export kept -o /data/lost.ply --retry-for 0 --server "$server_address"
refuse NOT_SERVING "${health[@]}"
info
grep -q '^device lost ' "$work/info.txt" || fail "latticectl info names no loss"
stop
rm "$data/lose"
start latticed --insecure
ctl export kept -o /data/after.ply >"$work/export.txt"
cmp "$data/before.ply" "$data/after.ply" || fail "the scene that came back is another"
echo "after the loss, the next server has the scene"
stop

umount "$image"/dev/nvidia[0-9]*
rm "$image"/dev/nvidia[0-9]*
refuse 'backend cuda: no CUDA device' latticed --insecure --backend cuda
start latticed --insecure
info
[[ $(grep -c '^backend  *' "$work/info.txt") == 1 ]] && grep -q '^backend  *cpu: ' "$work/info.txt" || fail "not on the CPU alone"
ctl export kept -o /data/cpu.ply >"$work/export.txt"
stop
echo "all passed"
