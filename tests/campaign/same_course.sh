#!/bin/sh
# The same seeds give the same campaign to the bit, whatever the number of threads.
# Usage: same_course.sh FAULT_CAMPAIGN
set -eu
digest() { "$1" --schedules 60 --seed 7000 --jobs "$2" | sed -n 's/^digest \([0-9a-f]*\),.*/\1/p'; }
one=$(digest "$1" 1)
three=$(digest "$1" 3)
[ -n "$one" ] || { echo "no digest was printed" >&2; exit 1; }
[ "$one" = "$three" ] || { echo "1 thread: $one, 3 threads: $three" >&2; exit 1; }
