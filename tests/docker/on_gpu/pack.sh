#!/usr/bin/env bash
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: pack.sh TAG FOLDER
# Packs podman's GPU image TAG into FOLDER, for test.sh on a machine with a GPU and without a container engine: the root
# file system without CUDA's libraries, the image's user, environment and health check, the Python client, and a library
# that loses the device.
set -euo pipefail
here=$(dirname "$(readlink -f "$0")")
root=$(cd "$here/../../.." && pwd)
readonly here root tag=$1 most_mb=60
mkdir -p "$2"
folder=$(readlink -f "$2")
readonly folder

rm -rf "${folder:?}"/*
image=$(podman image mount "$tag")
trap 'podman image unmount "$tag" >/dev/null' EXIT
tar -C "$image" --sort=name --numeric-owner --exclude=./usr/local/cuda --exclude='./dev/*' -c . |
  xz --x86 --lzma2=preset=6,dict=64MiB >"$folder/root.tar.xz"
podman image inspect --format '{{.Config.User}}' "$tag" >"$folder/user"
podman image inspect --format '{{range .Config.Env}}{{println .}}{{end}}' "$tag" | grep . >"$folder/environment"
podman image inspect --format '{{range .Config.Healthcheck.Test}}{{println .}}{{end}}' "$tag" | grep . |
  sed 1d >"$folder/health"  # without the word CMD
cc -shared -fPIC -O2 -Wall -Wextra -Werror -o "$folder/lose_device.so" "$here/lose_device.c"
(cd "$root/client/python" && /usr/bin/python3 setup.py -q build_py --build-lib "$folder/python")

mb=$(($(du -sb "$folder" | cut -f 1) / 1000000))
echo "$folder has $mb MB"
((mb < most_mb)) || { echo "pack.sh: $mb MB are over $most_mb" >&2; exit 1; }
