"""Tests of whole processes that share a boot of the machine. The list of a boot has a line for each: its name, variables of its
environment as NAME=VALUE, an empty field, and script and arguments, all between tabs (cansync_whole_processes in tests/CMakeLists.txt).

Inside the machine: boot_list.py LIST [NAME ...] runs all of them, or those named, one after another, each on its own. What each
took is in seconds of the machine's own: all, and those in which the processor had to work; only these cost time of the computer
around it. Of one that failed or was named all that it wrote is shown.
"""

import importlib
import os
import random
import re
import resource
import runpy
import select
import signal
import sys
import time
import typing

LIMIT = 900 * int(os.environ.get("CANSYNC_LONGER", "1"))  # seconds of the machine's own, for each
SKIPPED = 77
# What most of them use: brought in once here, and not by each of them. None of it looks at the environment.
COMMON = ("json", "jsonschema", "pty", "shutil", "subprocess", "tempfile", "unittest")
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


def become(entry, output):
    """Goes on as a process that Python has just begun with this script."""
    os.setsid()
    for number, file in enumerate((os.open(os.devnull, os.O_RDONLY), output.fileno(), output.fileno())):
        os.dup2(file, number)
    os.environ.update(entry.environment, CANSYNC_OWN_TIME="yes")
    script = entry.command[0]
    sys.argv[:] = entry.command
    sys.path[0:1] = [os.path.dirname(script), *filter(None, entry.environment.get("PYTHONPATH", "").split(":"))]
    random.seed()
    runpy.run_path(script, run_name="__main__")


def run(entry):
    """Its exit status, and what it wrote; None: it has not ended. Does not return where it goes on as the entry."""
    with open("/run/output", "w+", encoding="utf-8", errors="replace") as output:
        sys.stdout.flush()
        child = os.fork()
        if child == 0:
            become(entry, output)
            sys.exit()
        descriptor = os.pidfd_open(child)
        has_ended = select.select([descriptor], [], [], LIMIT)[0]
        os.close(descriptor)
        if not has_ended:
            os.killpg(child, signal.SIGKILL)  # and what it has started
        status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        output.seek(0)
        return status if has_ended else None, output.read()


def worked():
    """Seconds of the processor for all that has run and ended here."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def main():
    path, *names = sys.argv[1:]
    for name in COMMON:
        importlib.import_module(name)
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
            print(f"{output if names else ''}{entry.name}: passed, {took}", flush=True)
            continue
        failed.append(entry.name)
        how = {None: f"has not ended within {LIMIT} s", SKIPPED: "was skipped: there must be what it needs"}.get(status, f"exit code {status}")
        print(f"{output}\n{entry.name}: FAILED, {how}, {took}", flush=True)
    if failed:
        sys.exit(f"failed: {' '.join(failed)}")


if __name__ == "__main__":
    main()
