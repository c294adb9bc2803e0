# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# The step of ./dev ci that builds and runs the viewer and the Node example with Debian 12's Node 18, on a machine that
# has another Node. Debian's package cannot be installed beside another Node, so it is unpacked, with an npm of its age.
# bash does not stop at a failure inside a step, so commands are joined by &&.
readonly node_18=build/ci/node-18 npm_of_node_18=9.2.0

# Puts node and npm into $node_18/bin, unless apt has no package of Node 18.
node_18_unpack() {
  local version library needs plan
  as_root apt-get update -q
  version=$(apt-cache madison nodejs | awk '$3 ~ /^18\./ { print $3; exit }')
  if [[ -z $version ]]; then
    grep -qs '^VERSION_CODENAME=bookworm$' /etc/os-release &&
      die "apt finds no nodejs 18, although this is Debian 12"
    not_run "this machine's distribution has no Node 18"
    return
  fi
  library=$(apt-cache show "nodejs=$version" | sed -n 's/^Depends:.*\(libnode[0-9]*\).*/\1/p')
  mapfile -t needs < <(apt-cache show "$library=$version" | sed -n 's/^Depends: //p' | sed 's/ ([^)]*)//g; s/, /\n/g')
  if ! plan=$(apt-get install --simulate --no-install-recommends "${needs[@]}" 2>&1) || grep -q '^Inst nodejs ' <<<"$plan"; then
    not_run "what Debian's Node 18 needs cannot be installed beside this machine's Node"
    return
  fi
  need "what Node 18 needs" "${needs[@]}"
  rm -rf "$node_18" && mkdir -p "$node_18"/{root,bin} &&
    (cd "$node_18" && apt-get download -q "nodejs=$version" "$library=$version") &&
    printf '%s\n' "$node_18"/*.deb | xargs -I DEB dpkg -x DEB "$node_18/root" &&
    npm install --silent --no-fund --no-audit --prefix "$node_18/npm" "npm@$npm_of_node_18" &&
    ln -s "$PWD/$node_18"/root/usr/lib/*/libnode.so.* "$node_18/root/usr/lib" &&  # node looks for it there
    ln -s "$PWD/$node_18"/{root/usr/bin/node,npm/node_modules/.bin/npm} "$node_18/bin" ||
    die "Node 18 could not be unpacked"
}

# Bundles the viewer, its documentation and its tests anew, from the messages and samples of the Release build.
node_18_viewer() {
  local programs=$PWD/$ci_build tree=$PWD/build/ci/tree viewer=$PWD/$node_18/server/viewer
  export LATTICED_DECODER_WASM=$programs/client/decoder/wasm/decoder.wasm
  local script="node --preserve-symlinks --preserve-symlinks-main" readmes
  readmes=$(cd "$tree" && ls README.md ./*/README.md client/*/README.md | sed 's|^./||')
  mkdir -p "$node_18"/{client,server} && cp -a "$programs/client/web" "$node_18/client" && cd "$node_18/client/web" &&
    rm -r node_modules tests && npm ci --ignore-scripts --no-fund --no-audit --silent &&
    $script build.mjs web "$viewer" && $script build.mjs tests tests &&
    $script docs/build_docs.mjs "$tree" latticed.protoset "$viewer/docs" $readmes &&
    LATTICED=$programs/server/latticed LATTICECTL=$programs/client/cpp/latticectl \
      LATTICED_WRITE_STREAMS=$programs/tests/core/codec/draco3d_write_streams node --test tests/unit
}

node_18_example() {
  local tree=$PWD/$node_18/tree
  mkdir -p "$tree" && sources client/node proto | tar -cf - -T - | tar -xf - -C "$tree" &&
    "$ci_build/client/cpp/latticectl" sample vase --resolution 1 -o "$tree/vase.obj" &&
    (export LATTICED_DECODER_WASM=$PWD/$ci_build/client/decoder/wasm/decoder.wasm && cd "$tree/client/node" &&
      npm ci --no-fund --no-audit && npm run build) &&
    node tests/client/node/draco_points_test.mjs "$tree/client/node" tests/client/golden &&
    node tests/client/node/evaluate_patches_test.mjs "$tree/client/node" &&
    tests/client/with_server.sh "$ci_build" node "$tree/client/node/dist/drag.js" "$tree/vase.obj"
}

ci_node_18() {
  if [[ $(node --version) == v18.* ]]; then
    echo "this machine's own Node is 18: all other steps show that it serves"
    return
  fi
  node_18_unpack
  [[ -d $node_18/bin ]] || return 0
  export PATH=$PWD/$node_18/bin:$PATH npm_config_engine_strict=true  # npm refuses packages that need a newer Node
  [[ $(node --version) == v18.* ]] || die "Node 18 was unpacked, and node --version says: $(node --version 2>&1)"
  (node_18_viewer) || die "the viewer with Node $(node --version), npm $(npm --version)"
  node_18_example || die "the example for Node with Node $(node --version), npm $(npm --version)"
}
