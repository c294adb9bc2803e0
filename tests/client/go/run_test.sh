#!/usr/bin/env bash
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: run_test.sh BUILD
# Generates a Go client from the protos with Debian's packages, without a network, and runs it against a
# real server. Without the packages it exits with 77 (skipped), or fails if LATTICED_REQUIRE_GO is set.
set -euo pipefail
here=$(dirname "$(readlink -f "$0")")
root=$(readlink -f "$here/../../..")
build=$(readlink -f "$1")
work=$build/go
debian=/usr/share/gocode
googleapis=${LATTICED_GOOGLEAPIS_DIR:-$debian/src/github.com/grpc-ecosystem/grpc-gateway/third_party/googleapis}
missing=()
command -v go >/dev/null || missing+=(golang-go)
command -v protoc-gen-go-grpc >/dev/null || missing+=(protoc-gen-go-grpc)
[[ -d $debian/src/google.golang.org/grpc ]] || missing+=(golang-google-grpc-dev)
[[ -d $debian/src/google.golang.org/protobuf ]] || missing+=(golang-google-protobuf-dev)
if ((${#missing[@]})); then
  echo "skipped, missing: ${missing[*]}"
  [[ -n ${LATTICED_REQUIRE_GO:-} ]] && exit 1
  exit 77
fi

mkdir -p "$work/bin"
rm -rf "$work/src"
mkdir -p "$work/src/smoke"
cp "$here/"*.go "$work/src/smoke"
export GO111MODULE=off GOFLAGS= CGO_ENABLED=0 GOPATH=$work:$debian GOCACHE=$work/cache
# Debian's older packages of protoc-gen-go do not know `optional`; the newer ones conflict with packages that
# the build needs. The source, in golang-google-protobuf-dev, has neither problem.
go build -o "$work/bin/protoc-gen-go" google.golang.org/protobuf/cmd/protoc-gen-go

mapfile -t protos < <(cd "$root/proto" && printf '%s\n' latticed/v1/*.proto)
packages=Mgoogle/rpc/status.proto=latticed/rpc
for proto in "${protos[@]}"; do packages+=,M$proto=latticed/v1; done
protoc -I "$root/proto" -I "$googleapis" --plugin=protoc-gen-go="$work/bin/protoc-gen-go" \
  --go_out="$work/src" --go_opt="$packages" --go-grpc_out="$work/src" --go-grpc_opt="$packages" \
  google/rpc/status.proto "${protos[@]}"
go build -o "$work/bin/smoke" smoke
"$here/../with_server.sh" "$build" "$work/bin/smoke"
