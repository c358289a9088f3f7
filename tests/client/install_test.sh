#!/bin/bash
# Installs the client library into an empty folder and builds and runs against it what a stranger would write:
# C++ by find_package, C by pkg-config. Compares what the library exports with the list beside this file.
#
#   install_test.sh BUILD_FOLDER CC CXX        exit 0: all is as it should be
#   install_test.sh --list LIBRARY             prints the list for exported_symbols.txt
set -eu
here=$(cd "$(dirname "$0")" && pwd)

# Names of programs only: the rest of a line depends on the compiler.
exported() { nm -DC --defined-only "$1" | cut -d' ' -f3- | sed 's/@@\?LIBCANSYNC_1$//' | LC_ALL=C sort -u; }

if [ "$1" = --list ]; then
  exported "$2"
  exit
fi
build=$1 cc=$2 cxx=$3
work=$(mktemp -d)
trap 'rm -r -- "$work"' EXIT
prefix=$work/prefix
for component in library development; do
  cmake --install "$build" --component $component --prefix "$prefix" >"$work/install.log"
done

shopt -s globstar
library=$(echo "$prefix"/**/libcansync.so.1)
diff -u "$here/exported_symbols.txt" <(exported "$library") || {
  echo "the library does not export what exported_symbols.txt says (-: missing, +: new)"
  exit 1
}

# Headers find one another, the data model and the standard library, and nothing else.
if grep -rnE '#[[:space:]]*include[[:space:]]*["<](dds|client|text|can)/' "$prefix/include/cansync" --exclude=cansync.h --exclude=gateway.h; then
  echo "an installed header includes what is not installed"
  exit 1
fi
for model in cansync gateway layer2; do [ -f "$prefix/share/cansync/idl/$model.idl" ]; done

# A domain of this test's own is not needed: nobody serves a bus of this name.
domain=$((1 + $$ % 100))
cmake -S "$here/install" -B "$work/stranger" -DCMAKE_CXX_COMPILER="$cxx" -DCMAKE_PREFIX_PATH="$prefix" >"$work/cmake.log" || {
  cat "$work/cmake.log"
  exit 1
}
cmake --build "$work/stranger" >"$work/build.log" || {
  cat "$work/build.log"
  exit 1
}
"$work/stranger/stranger" $domain >"$work/out"
cat "$work/out"
grep -q 'NoDaemon: no daemon found' "$work/out"
grep -q 'SetupError: .*domain' "$work/out"

PKG_CONFIG_PATH=$(dirname "$(echo "$prefix"/**/cansync.pc)")
export PKG_CONFIG_PATH
read -ra flags <<<"$(pkg-config --cflags --libs cansync)"
"$cc" -std=c11 -Wall -Wextra -Wpedantic -Werror -o "$work/stranger_c" "$here/install/stranger.c" "${flags[@]}"
LD_LIBRARY_PATH=$(dirname "$library") "$work/stranger_c" $domain >"$work/out"
cat "$work/out"
grep -q "^$(pkg-config --modversion cansync) no_daemon: no daemon found" "$work/out"
