#!/usr/bin/env bash
# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# usage: documents_test.sh ROOT
# Fails if a README has 200 lines or more, or if it links or names a file that does not exist. Names are paths in
# backquotes, relative to the root or to the README's folder.
set -euo pipefail
cd "$1"
failures=0
fail() { echo "$1"; failures=$((failures + 1)); }

links() { grep -oP '\]\(\K(?!https?:)[^)#]+' "$1" || true; }
names() { sed '/^ *```/,/^ *```/d' "$1" | grep -oP '`\K[\w.-]+(/[\w.-]+)+\.(h|cc|cuh?|proto|md|py|ts|sh|cfg|yaml|toml)(?=`)' || true; }

mapfile -t readmes < <(find . -name README.md -not -path '*/node_modules/*' -not -path '*/build/*' -printf '%P\n' | sort)
((${#readmes[@]} > 5)) || fail "only ${#readmes[@]} READMEs found under $1"
for readme in "${readmes[@]}"; do
  folder=$(dirname "$readme")
  lines=$(wc -l <"$readme")
  ((lines < 200)) || fail "$readme: $lines lines; 200 are too many to read"
  while read -r link; do [[ -e $folder/$link ]] || fail "$readme: $link does not exist"; done < <(links "$readme")
  while read -r name; do [[ -e $name || -e $folder/$name ]] || fail "$readme: $name does not exist"; done < <(names "$readme")
done

((failures == 0)) && echo "documents: ${#readmes[@]} READMEs" || { echo "$failures violations"; exit 1; }
