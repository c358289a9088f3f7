#!/bin/bash
# Holds the layers of lib/ apart.
#
#   sans_io_check.sh ROOT        exit 1 and one line per violation, when there is any under ROOT/lib
#   sans_io_check.sh --self-test plants each kind of violation in a scratch tree and expects it to be found
#
# lib/cansync is sans-IO: it may include only what is listed here, and names no clock. Every other layer of
# lib/ may use only the layers listed for it.
set -u

# Standard headers the protocol core may use: nothing that reaches a file, a thread or the system.
core_std='algorithm|array|bit|bitset|chrono|compare|concepts|cstddef|cstdint|cstring|deque|functional|initializer_list|iterator|limits|memory|new|numeric|optional|ranges|span|string|string_view|tuple|type_traits|utility|variant|vector'
core_words='steady_clock|system_clock|high_resolution_clock|utc_clock|clock_gettime|gettimeofday|std::time\b|this_thread|fopen|printf|getenv|std::(cout|cerr|clog)'

# layer: folders whose headers it may include with "folder/..."
allowed_folders() {
  case $1 in
    text) echo 'text' ;; # knows nothing of the project
    profile) echo 'text|profile' ;; # knows no bus
    can) echo 'can' ;;
    cansync) echo 'cansync' ;; # and can/frame.h
    sim) echo 'text|can|cansync|sim' ;;
    rt) echo 'can|rt' ;; # knows no CANsync
    sync) echo 'can|rt|sync' ;; # knows no CANsync
    dds) echo 'cansync|rt|dds' ;; # knows no bus
    client) echo 'cansync|dds|client' ;;
  esac
}

failures=0
report() { # file:line:text..., rule
  while IFS= read -r line; do
    echo "$line   <- $1"
    failures=$((failures + 1))
  done
}

sources() { find "$1" -type f \( -name '*.h' -o -name '*.cpp' -o -name '*.hpp' -o -name '*.c' \) 2>/dev/null | sort; }

# Lines of the layer's sources that match $2 and not $3 (empty: nothing is excepted).
matching() {
  sources "$1" | while IFS= read -r file; do
    grep -nHE -- "$2" "$file" | { if [ -n "${3:-}" ]; then grep -vE -- "$3"; else cat; fi; }
  done
}

check() {
  local lib=$1/lib layer
  if [ -z "$(sources "$lib/cansync")" ]; then
    echo "sans_io_check: no sources in $lib/cansync"
    return 1
  fi
  failures=0
  for layer in text profile can cansync sim rt sync dds client; do
    # Includes of another folder. A generated or system header carries no folder of ours.
    report "lib/$layer may not include this folder" < <(
      matching "$lib/$layer" '^[[:space:]]*#[[:space:]]*include[[:space:]]*["<](text|profile|can|cansync|sim|rt|sync|dds|client|daemon|tools)/' \
        "include[[:space:]]*[\"<](($(allowed_folders "$layer"))/$( [ "$layer" = cansync ] && echo '|can/frame\.h'))" |
        grep -vE 'include[[:space:]]*<dds/')
  done
  report 'lib/can may not know CANsync' < <(matching "$lib/can" 'cansync')
  for layer in rt sync; do
    report "lib/$layer may not know CANsync" < <(matching "$lib/$layer" '(cansync/|cansync::|namespace cansync)')
  done
  for layer in text profile can cansync sim rt sync; do
    report "lib/$layer may not use DDS" < <(
      matching "$lib/$layer" '#[[:space:]]*include[[:space:]]*["<]((dds|ddsc)/|dds[a-z_]*\.h|cansync\.h)|\bdds_[a-z]+')
  done
  report 'not on the list of headers for the sans-IO core' < <(
    matching "$lib/cansync" '^[[:space:]]*#[[:space:]]*include' \
      "include[[:space:]]*(\"can/frame\.h\"|\"cansync/[a-z_]+\.h\"|<($core_std)>)")
  report 'the sans-IO core reads no clock and no file' < <(matching "$lib/cansync" "$core_words")
  [ "$failures" -eq 0 ]
}

# --- self-test

plant() { # file, line: the check must name exactly this file
  local tree out
  tree=$(mktemp -d) || exit 2
  mkdir -p "$tree"/lib/{text,profile,can,cansync,sim,rt,sync,dds,client}
  printf '#include <array>\n#include "can/frame.h"\n#include "cansync/numbers.h"\n' >"$tree/lib/cansync/clean.cpp"
  printf '#include "can/bus.h"\n' >"$tree/lib/sim/clean.h"
  printf '#include <dds/dds.h>\n#include "cansync/jobs.h"\n#include "cansync.h"\n' >"$tree/lib/dds/clean.cpp"
  if [ -n "$1" ]; then printf '%s\n' "$2" >"$tree/lib/$1"; fi
  out=$(check "$tree")
  local status=$?
  rm -r -- "$tree"
  if [ -z "$1" ]; then
    [ $status -eq 0 ] && return 0
    echo "self-test: a clean tree is refused: $out"
  else
    [ $status -ne 0 ] && [[ $out == *"lib/$1"* ]] && [[ $out != *clean* ]] && return 0
    echo "self-test: not found: lib/$1: $2"
  fi
  return 1
}

self_test() {
  local bad=0
  plant '' '' || bad=1
  local header
  for header in thread mutex fstream iostream atomic sys/socket.h unistd.h time.h ctime random fmt/format.h; do
    plant cansync/planted.cpp "#include <$header>" || bad=1
  done
  plant cansync/planted.h '# include "can/bus.h"' || bad=1
  plant cansync/planted.h '#include "planted.h"' || bad=1
  plant cansync/planted.cpp 'auto now = std::chrono::steady_clock::now();' || bad=1
  plant cansync/planted.cpp 'using Clock = std::chrono::system_clock;' || bad=1
  plant cansync/planted.cpp '#include "rt/ring.h"' || bad=1
  plant can/planted.h '#include "cansync/telegram.h"' || bad=1
  plant text/planted.h '#include "can/frame.h"' || bad=1
  plant rt/planted.h '#include "text/text_file.h"' || bad=1
  plant profile/planted.h '#include "cansync/numbers.h"' || bad=1
  plant dds/planted.cpp '#include "profile/profile.h"' || bad=1
  plant can/planted.cpp 'int f(cansync::SlaveNumber);' || bad=1
  plant sim/planted.cpp '#include <dds/dds.h>' || bad=1
  plant sim/planted.cpp '#include "rt/ring.h"' || bad=1
  plant rt/planted.h '#include "cansync/jobs.h"' || bad=1
  plant rt/planted.h 'void f(const cansync::Telegram&);' || bad=1
  plant rt/planted.cpp 'auto x = dds_create_participant(0, nullptr, nullptr);' || bad=1
  plant sync/planted.h '#include "cansync/timing.h"' || bad=1
  plant sync/planted.cpp '#include "sim/clock.h"' || bad=1
  plant sync/planted.cpp '#include <dds/dds.h>' || bad=1
  plant rt/planted.cpp '#include "sync/phase_lock.h"' || bad=1
  plant dds/planted.cpp '#include "sync/phase_lock.h"' || bad=1
  plant dds/planted.cpp '#include "can/bus.h"' || bad=1
  plant dds/planted.cpp '#include "client/client.h"' || bad=1
  plant client/planted.cpp '#include "daemon/cansync/exchange.h"' || bad=1
  local empty
  empty=$(mktemp -d) || exit 2
  if check "$empty" >/dev/null; then
    echo 'self-test: a tree without sources passes'
    bad=1
  fi
  rm -r -- "$empty"
  [ $bad -eq 0 ] && echo 'self-test: every planted violation was found'
  return $bad
}

case ${1:-} in
  --self-test) self_test ;;
  '')
    echo "usage: $0 ROOT | --self-test" >&2
    exit 2
    ;;
  *) check "$1" && echo 'the layers of lib/ are apart' ;;
esac
