# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# For scripts that run a README's blocks unchanged. They must set `root`, the tree's root, and define `fail`.

declare -A blocks=()  # "FILE, HEADING, N": the text of the Nth fenced block under that heading

read_blocks() {  # FILE
  local line heading='' block='' n
  while IFS= read -r line; do
    if [[ $line =~ ^\ *'```' && -n $block ]]; then
      block=
    elif [[ $line =~ ^\ *'```' ]]; then
      for ((n = 1; ; ++n)); do
        block="$1, $heading, $n"
        [[ -n ${blocks[$block]+there} ]] || break
      done
      blocks[$block]=
    elif [[ -n $block ]]; then
      blocks[$block]+=$line$'\n'
    elif [[ $line =~ ^#+\ (.*) ]]; then
      heading=${BASH_REMATCH[1]}
    fi
  done <"$root/$1"
}

# Writes the block to the file `block`, and removes it from `blocks`.
take() {  # NAME
  [[ -n ${blocks[$1]+there} ]] || fail "no block is called '$1'"
  printf '%s' "${blocks[$1]}" >block
  unset 'blocks[$1]'
}

# Runs COMMAND with the block's file as its last argument. Copies the output to `output.txt`.
run() {  # NAME COMMAND…
  take "$1"
  echo "== $1"
  "${@:2}" block 2>&1 | tee output.txt
}
