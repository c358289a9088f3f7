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

# The generated types and Cyclone DDS, as far as programs or headers include them that look into one folder alone.
data_model() {
  "$cxx" -std=c++20 -M -I "$1" -x c++ "${@:2}" | tr -d '\\' | tr -s ' ' '\n' |
    grep -E '/cansync/(cansync|cansync_slave|gateway|j1939|layer2)\.h$|/(dds|ddsc)/'
}

# Headers find one another and the standard library, and nothing else; topics.h the data model, too.
headers=("$here/install/stranger.cpp")
for header in "$prefix"/include/cansync/**/*.h; do
  case ${header##*/} in cansync.h | cansync_slave.h | gateway.h | j1939.h | layer2.h | topics.h) ;; *) headers+=("$header") ;; esac
done
[ ${#headers[@]} -ge 20 ]
if data_model "$prefix/include" "${headers[@]}"; then
  echo "the data model is for <cansync/topics.h>, but included by"
  for header in "${headers[@]}"; do data_model "$prefix/include" "$header" >"$work/found" && echo "${header#"$prefix/include/"}"; done
  exit 1
fi
# The check finds what it is for: in topics.h, and where it is planted.
data_model "$prefix/include" "$prefix/include/cansync/topics.h" | grep -q '/cansync/gateway.h$'
cp -r "$prefix/include" "$work/planted"
sed -i '1a #include "gateway.h"' "$work/planted/cansync/export.h"
data_model "$work/planted" "$work/planted/cansync/client.h" | grep -q '/cansync/gateway.h$'
for model in cansync cansync_slave gateway j1939 layer2; do [ -f "$prefix/share/cansync/idl/$model.idl" ]; done
for example in "$here"/../../tools/examples/*.{c,cpp,xml}; do cmp "$example" "$prefix/share/cansync/examples/${example##*/}"; done

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
"$work/stranger/stranger_topics"
# The same program without CMake, and without Cyclone DDS's headers.
"$cxx" -std=c++20 -Wall -Wextra -Wpedantic -Werror -I "$prefix/include" -o "$work/stranger_alone" "$here/install/stranger.cpp" \
  -L "$(dirname "$library")" -lcansync
for program in "$work/stranger/stranger" "$work/stranger_alone"; do
  LD_LIBRARY_PATH=$(dirname "$library") "$program" $domain >"$work/out"
  cat "$work/out"
  grep -q 'NoDaemon: no daemon found' "$work/out"
  grep -q 'SetupError: .*domain' "$work/out"
done

PKG_CONFIG_PATH=$(dirname "$(echo "$prefix"/**/cansync.pc)")
export PKG_CONFIG_PATH
read -ra flags <<<"$(pkg-config --cflags --libs cansync)"
"$cc" -std=c11 -Wall -Wextra -Wpedantic -Werror -o "$work/stranger_c" "$here/install/stranger.c" "${flags[@]}"
LD_LIBRARY_PATH=$(dirname "$library") "$work/stranger_c" $domain >"$work/out"
cat "$work/out"
grep -q "^$(pkg-config --modversion cansync) no_daemon: no daemon found" "$work/out"
# The first programs, by the lines of docs/client-library.md; tests/end_to_end/examples_test.py runs them.
"$cxx" -std=c++20 "$prefix/share/cansync/examples/first_client.cpp" "${flags[@]}" -o "$work/first_cpp"
"$cc" -std=gnu11 "$prefix/share/cansync/examples/first_client.c" "${flags[@]}" -o "$work/first_c"
