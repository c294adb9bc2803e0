#!/usr/bin/env bash
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: container_test.sh FOLDER [CUDA]
# Builds the CPU image and runs it by compose.yaml with the commands of docker/README.md. Checks that the container is
# confined as that file says, and uses its ports with README's Python example and by HTTP. With CUDA, the folder of a
# CUDA toolkit, it then builds the GPU image for one device architecture. That one runs on the CPU here, as it does
# wherever it is given no GPU. Images, networks and containers are separate from this machine's own, and are deleted
# afterwards. The example's files go to FOLDER, and what the toolkit does not allow to FOLDER/not_run.txt.
set -euo pipefail
root=$(cd "$(dirname "$(readlink -f "$0")")/../.." && pwd)
mkdir -p "$1"
work=$(readlink -f "$1")
readonly root work cuda=${2:-} tag=latticed:cpu gpu_tag=latticed:gpu most_mb=300 patience_s=60
name=docker_latticed_1
storage=$(mktemp -d /var/tmp/latticed.XXXXXX)
readonly storage
export CONTAINERS_CONF=$root/docker/containers.conf CONTAINERS_STORAGE_CONF=$storage/storage.conf
# No image is kept, so layers are cached only where two images begin with the same packages.
BUILDAH_LAYERS=$([[ -n $cuda ]] && echo true || echo false)
export BUILDAH_LAYERS
cat >"$CONTAINERS_STORAGE_CONF" <<CONF
[storage]
driver = "overlay"
graphroot = "$storage/images"
runroot = "$storage/run"
CONF

fail() {
  printf 'container_test.sh: %s\n' "$*" >&2
  podman logs "$name" >&2 2>/dev/null || true
  exit 1
}

clean() {
  podman rm --all --force --time 0 >/dev/null 2>&1 || true
  podman rmi --all --force >/dev/null 2>&1 || true
  umount "$storage/images/overlay" 2>/dev/null || true
  rm -rf --one-file-system "$storage"
}
trap clean EXIT

source "$root/tests/support/readme_blocks.sh"
read_blocks docker/README.md

# Prints the first COUNT ports from 20200 on that nobody listens on. They are below the ephemeral ports.
free_ports() {  # COUNT
  local port ports=()
  for port in {20200..20299}; do
    (exec 3<>"/dev/tcp/127.0.0.1/$port") 2>/dev/null || ports+=("$port")
    ((${#ports[@]} < $1)) || { echo "${ports[@]}"; return; }
  done
  fail "ports 20200 to 20299 are all in use"
}

# ask URL TEXT [grpc-web]: fails unless the answer holds TEXT. With grpc-web it calls an rpc with an empty message.
ask() {
  /usr/bin/python3 - "$@" <<'PYTHON' || fail "$1 does not answer as it should"
import sys, urllib.request
url, text, *rpc = sys.argv[1:]
request = urllib.request.Request(url)
if rpc:
    request = urllib.request.Request(url, bytes(5), {"content-type": "application/grpc-web+proto"})
answer = urllib.request.urlopen(request, timeout=10).read().decode(errors="replace")
sys.exit(0 if text in answer else f"no {text!r} in {answer[:2000]!r}")
PYTHON
}

# Waits until the image's own health check succeeds.
wait_for_health() {
  local i
  for ((i = 0; i < patience_s; ++i)); do
    podman healthcheck run "$name" >/dev/null 2>&1 && return
    sleep 1
  done
  fail "not healthy after $patience_s s"
}

check_confined() {
  local status line
  [[ $(podman ps --format '{{.Names}}') == "$name" ]] || fail "not this service alone is up"
  [[ $(podman port "$name" | sed 's/.* -> //; s/:.*//' | sort -u) == 127.0.0.1 ]] || fail "published to others"
  status=$(podman exec "$name" cat /proc/1/status)
  for line in 'Uid:\s65532\s' 'CapEff:\s0+$' 'CapBnd:\s0+$' 'NoNewPrivs:\s1$'; do
    grep -qP "^$line" <<<"$status" || fail "not confined, no $line in $status"
  done
  podman exec "$name" grep -q '^[^ ]* / [^ ]* ro,' /proc/mounts || fail "the root is not read-only"
}

"$root/docker/build_image.sh" "$tag"
mb=$(($(podman image inspect --format '{{.Size}}' "$tag") / 1000000))
echo "the image has $mb MB"
((mb <= most_mb)) || fail "the image has $mb MB, over $most_mb"

# Copies docker/ and makes podman keep its networks in the temporary storage.
rm -rf "$work/docker"
cp -r "$root/docker" "$work"
sed -i "/^\[network\]/a network_config_dir = \"$storage/networks\"" "$work/docker/containers.conf"
export CONTAINERS_CONF=$work/docker/containers.conf
cd "$work"
read -r port http admin < <(free_ports 3)
export LATTICED_GRPC_PORT=$port LATTICED_HTTP_PORT=$http LATTICED_ADMIN_PORT=$admin
run "docker/README.md, Without Docker, without a registry, 1" bash -euo pipefail
wait_for_health
check_confined
podman exec "$name" latticectl bench vase --resolution 1 --segments 1 --edits 1 --server 127.0.0.1:50151 >bench.txt 2>&1 ||
  fail "the load generator does not run: $(<bench.txt)"

# The image's latticectl makes the mesh; the Python client runs on this machine.
podman run --rm --network none --read-only --cap-drop ALL --user "$EUID" --volume "$work:/work" \
  --entrypoint latticectl "$tag" sample vase --resolution 1 -o /work/my.obj
(cd "$root/client/python" && /usr/bin/python3 setup.py -q build_py --build-lib "$work/package") >package.txt 2>&1 ||
  { cat package.txt; exit 1; }
PYTHONPATH=$work/package LATTICED_SERVER=127.0.0.1:$port \
  /usr/bin/python3 "$root/client/python/examples/quickstart.py"
[[ $(head -c 4 deformed.glb) == glTF ]] || fail "the example left no deformed.glb"
ask "http://127.0.0.1:$http/latticed.v1.ServerService/GetServerInfo" "grpc-status: 0" grpc-web
/usr/bin/python3 "$root/tests/support/served_viewer.py" "http://127.0.0.1:$http/" || fail "the viewer is not served"
ask "http://127.0.0.1:$admin/readyz" ready
ask "http://127.0.0.1:$admin/metrics" 'latticed_rpc_finished_total{method="SceneService/Export",code="OK"} 1'

[[ -z $(podman exec "$name" find /tmp /var/tmp -mindepth 1) ]] || fail "it has written files"

podman-compose -f docker/compose.yaml stop --timeout 30 latticed
[[ $(podman inspect --format '{{.State.ExitCode}}' "$name") == 0 ]] || fail "the server did not drain and end by itself"
podman logs "$name" 2>&1 | grep -q '"message":"stopped"' || fail "the log does not end with 'stopped'"
run "docker/README.md, Without Docker, without a registry, 2" bash -euo pipefail
[[ -z $(podman ps --all --quiet) ]] || fail "a container is left"
echo "container: built, ran read-only without capabilities, served gRPC, gRPC-Web and metrics, drained"

[[ -n $cuda ]] || exit 0
if ! why=$(podman run --rm --network none --volume "$cuda:/usr/local/cuda:ro" localhost/latticed-base:bookworm \
  /usr/local/cuda/bin/nvcc --version 2>&1); then
  echo "the GPU image is not built: nvcc of $cuda does not run in a container: $why" >not_run.txt
  exit 0
fi
blas=$(cd "$cuda" && compgen -G 'lib64/libcublas*.so.[0-9][0-9]' || true)
[[ -n $blas ]] || echo "the GPU image is built without cuBLAS: $cuda has none in lib64" >not_run.txt
CMAKE_ARGS=-DCMAKE_CUDA_ARCHITECTURES=90-real "$root/docker/build_image.sh" "$gpu_tag" "$cuda"
folder=$(podman image mount "$gpu_tag")
blas_mb=$(du -sm --apparent-size "$folder/usr/local/cuda" | cut -f 1)
mb=$(($(podman image inspect --format '{{.Size}}' "$gpu_tag") / 1000000 - blas_mb * 1048576 / 1000000))
echo "the GPU image has $mb MB and $blas_mb MiB of cuBLAS"
((mb <= most_mb)) || fail "the GPU image has $mb MB, over $most_mb"
[[ $(cd "$folder/usr/local/cuda" && find . -type f -printf '%P\n' | sort) == "$(sort <<<"$blas")" ]] ||
  fail "more of CUDA than cuBLAS: $(find "$folder/usr/local/cuda" -type f)"
podman image unmount "$gpu_tag" >/dev/null
if podman run --rm --network none --read-only --cap-drop ALL "$gpu_tag" --insecure --backend cuda >gpu.txt 2>&1; then
  fail "the GPU image has a CUDA backend without a GPU"
fi
grep -q 'backend cuda: no CUDA device: .*cudaError' gpu.txt || fail "CUDA's runtime is not in the GPU image: $(<gpu.txt)"

name=docker_latticed-gpu_1
podman-compose -f docker/compose.yaml up --detach latticed-gpu
wait_for_health
check_confined
podman exec "$name" latticectl info --server 127.0.0.1:50151 | tee info.txt
grep -q '^backend  *cpu: ' info.txt || fail "the GPU image serves by no CPU"
podman exec "$name" latticectl bench vase --resolution 1 --segments 1 --edits 1 --server 127.0.0.1:50151 >bench.txt 2>&1 ||
  fail "the load generator does not run: $(<bench.txt)"
/usr/bin/python3 "$root/tests/support/served_viewer.py" "http://127.0.0.1:$http/" || fail "the GPU image has no viewer"
podman-compose -f docker/compose.yaml down --timeout 30 latticed-gpu
echo "container: the GPU image built, ran read-only without capabilities on the CPU, and says what CUDA lacks"
