"""Tests of whole processes that share a boot of the machine. The list of a boot has a line for each: its name, variables of its
environment as NAME=VALUE, an empty field, and script and arguments, all between tabs (cansync_whole_processes in tests/CMakeLists.txt).

Inside the machine: boot_list.py LIST [NAME ...] runs all of them, or those named, one after another, each on its own. What each
took is in seconds of the machine's own: all, and those in which the processor had to work; only these cost time of the computer
around it. Of one that failed all that it wrote is shown.
"""

import os
import re
import resource
import signal
import subprocess
import sys
import time
import typing

LIMIT = 900  # seconds of the machine's own, for each
SKIPPED = 77
SKIPPED_CASES = re.compile(r"^OK \(skipped=", re.MULTILINE)  # of unittest


class Entry(typing.NamedTuple):
    name: str
    environment: dict
    command: list


def read(path):
    entries = []
    with open(path, encoding="utf-8") as file:
        for line in file:
            name, *fields = line.rstrip("\n").split("\t")
            cut = fields.index("")
            entries.append(Entry(name, dict(field.split("=", 1) for field in fields[:cut]), [f for f in fields[cut:] if f]))
    return entries


def files(entries):
    """What the environments name: programs, and what a folder and those in it have of programs and Python."""
    found = set()
    for value in {os.path.normpath(value) for entry in entries for value in entry.environment.values() if value.startswith("/")}:
        if os.path.isfile(value):
            found.add(value)
        for folder in [value, *sorted(os.scandir(value), key=lambda each: each.path)] if os.path.isdir(value) else []:
            if os.path.isdir(folder):
                found |= {each.path for each in os.scandir(folder) if each.is_file() and is_needed(each.path)}
    return sorted(found)


def is_needed(path):
    return path.endswith((".py", ".pyi", ".so", ".typed")) or os.access(path, os.X_OK)


def run(entry):
    """Its exit status, and what it wrote; None: it has not ended."""
    with open("/run/output", "w+", encoding="utf-8", errors="replace") as output:
        process = subprocess.Popen([sys.executable, "-B", *entry.command], env={**os.environ, **entry.environment, "CANSYNC_OWN_TIME": "yes"}, stdin=subprocess.DEVNULL,
                                   stdout=output, stderr=subprocess.STDOUT, start_new_session=True)
        try:
            status = process.wait(LIMIT)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)  # and what it has started
            process.wait(LIMIT)
            status = None
        output.seek(0)
        return status, output.read()


def worked():
    """Seconds of the processor for all that has run and ended here."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def main():
    path, *names = sys.argv[1:]
    failed = []
    for entry in read(path):
        if names and entry.name not in names:
            continue
        begin, before = time.monotonic(), worked()
        status, output = run(entry)
        took = f"{time.monotonic() - begin:.3f} s, {worked() - before:.1f} s of work"
        if status == 0 and SKIPPED_CASES.search(output):
            status = SKIPPED
        if status == 0:
            print(f"{entry.name}: passed, {took}", flush=True)
            continue
        failed.append(entry.name)
        how = {None: f"has not ended within {LIMIT} s", SKIPPED: "was skipped: there must be what it needs"}.get(status, f"exit code {status}")
        print(f"{output}\n{entry.name}: FAILED, {how}, {took}", flush=True)
    if failed:
        sys.exit(f"failed: {' '.join(failed)}")


if __name__ == "__main__":
    main()
