#!/bin/sh
# The same seeds give the same campaign to the bit, whatever the number of threads.
# Usage: same_course.sh FAULT_CAMPAIGN
set -eu
program=$1
digest() { "$program" --schedules 60 --seed 7000 --jobs "$@" | sed -n 's/^digest \([0-9a-f]*\),.*/\1/p'; }
for course in "" "--course other_master" "--course which_drive"; do
  # shellcheck disable=SC2086  # two words or none
  one=$(digest 1 $course)
  # shellcheck disable=SC2086
  three=$(digest 3 $course)
  [ -n "$one" ] || { echo "no digest was printed" >&2; exit 1; }
  [ "$one" = "$three" ] || { echo "$course: 1 thread: $one, 3 threads: $three" >&2; exit 1; }
done
