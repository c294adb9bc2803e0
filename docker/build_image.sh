#!/usr/bin/env bash
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: build_image.sh TAG [CUDA]
# Builds the CPU image with podman, as root on Debian 12. debootstrap makes the base image from this machine's own
# package sources, so no image registry is needed. The build uses this machine's caches of ccache and npm.
#
# With CUDA, a folder with a CUDA toolkit such as /usr/local/cuda, it builds the GPU image. The toolkit is mounted during
# the build only. The runtime's base then has the toolkit's cuBLAS, as NVIDIA's runtime images do. CMAKE_ARGS in the
# environment are more options for CMake.
set -euo pipefail
root=$(cd "$(dirname "$(readlink -f "$0")")/.." && pwd)
cuda=${2:+$(readlink -f "$2")}
readonly root tag=$1 cuda base=localhost/latticed-base:bookworm
export CONTAINERS_CONF=$root/docker/containers.conf

say() { printf 'build_image.sh: %s\n' "$*" >&2; }
die() { say "$@"; exit 1; }

# The Debian suites among this machine's package sources, as lines of sources.list. Other sources stay out of images.
debian_sources() {
  apt-get indextargets --format '$(ORIGIN) deb $(SITE) $(RELEASE) $(COMPONENT)' 'Created-By: Packages' |
    sed -n 's/^Debian deb/deb/p' | sort -u
}

# As in Debian's published images, there are no caches and no documents, and dpkg does not wait for the disk.
make_base() {
  local folder=$scratch/root sources
  sources=$(debian_sources)
  grep -q ' bookworm main$' <<<"$sources" || die "this machine has no Debian 12 among its package sources"
  debootstrap --variant=minbase bookworm "$folder" "$(sed -n 's/^deb \(.*\) bookworm main$/\1/p;T;q' <<<"$sources")" \
    >"$scratch/log.txt" || { tail -n 20 "$scratch/log.txt" >&2; die "debootstrap failed"; }
  printf '%s\n' "$sources" >"$folder/etc/apt/sources.list"
  echo force-unsafe-io >"$folder/etc/dpkg/dpkg.cfg.d/unsafe-io"
  tar -C "$folder" --exclude='./var/cache/apt/*' --exclude='./var/lib/apt/lists/*' --exclude='./usr/share/doc/*' \
    --exclude='./usr/share/man/*' --exclude='./usr/share/locale/*' -c . | podman import --quiet - "$base"
}

# cudart is in the programs, and they load cuBLAS where they find it. An image without it has no gemm pipelines.
make_cuda_base() {
  local folder=$scratch/cuda library
  mkdir -p "$folder/lib64"
  for library in libcublas libcublasLt; do
    cp -L "$cuda/lib64/$library.so."[0-9][0-9] "$folder/lib64" || say "the image is built without $library"
  done
  podman build --quiet --format docker --tag "$base-cuda" --file - "$folder" <<DOCKERFILE
FROM $base
COPY lib64 /usr/local/cuda/lib64
RUN echo /usr/local/cuda/lib64 >/etc/ld.so.conf.d/cuda.conf && ldconfig
DOCKERFILE
}

((EUID == 0)) || die "run it as root: debootstrap and containers need that here"
why=$(unshare --mount --pid --fork --mount-proc true 2>&1) ||
  die "this machine allows no containers, neither mounts nor namespaces: $why"

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
podman image exists "$base" || make_base
runtime=$base options=()
if [[ -n $cuda ]]; then
  [[ -x $cuda/bin/nvcc ]] || die "$cuda has no bin/nvcc"
  podman image exists "$base-cuda" || make_cuda_base
  runtime=$base-cuda options+=(--volume "$cuda:/usr/local/cuda:ro" --build-arg LATTICED_CUDA=ON)
fi
[[ -z ${CMAKE_ARGS:-} ]] || options+=(--build-arg CMAKE_ARGS="$CMAKE_ARGS")
cache=$(ccache --get-config cache_dir 2>/dev/null) && [[ -d $cache ]] &&
  options+=(--volume "$cache:/root/.cache/ccache" ${LANG:+--build-arg LANG="$LANG"})
cache=$(npm config get cache 2>/dev/null) && [[ -d $cache ]] && options+=(--volume "$cache:/root/.npm")
podman build --format docker --file "$root/docker/Dockerfile" --tag "$tag" \
  --build-arg BUILD_BASE="$base" --build-arg RUNTIME_BASE="$runtime" \
  --build-arg LATTICED_COMMIT="$(git -C "$root" rev-parse --short=12 HEAD 2>/dev/null)" \
  ${options[@]+"${options[@]}"} "$root"
