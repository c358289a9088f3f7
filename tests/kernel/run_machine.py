"""Boots the machine of machine.py and runs tests or a program in it.

    run_machine.py tests FILES [-k PATTERN] ...        tests of this folder: FILES as "*_on_vcan_test.py"; the rest goes to unittest
    run_machine.py program PROGRAM [ARGUMENT ...]      a Python program of this folder; paths in its arguments are those of programs
    run_machine.py processes BOOT [NAME ...]           tests of whole processes in a list of build/PRESET/tests/boots, all or those named

CANSYNC_SEED in the environment: another number is another course of everything that chance decides inside; the same number with
the same command is the same course. Without it courses 1 and 2, as machine.in_courses says.
CANSYNC_LONGER: so many times as long as usual may all of it take, and each test of whole processes (default 1).

Exit code: that of the tests or the program; 77 when this computer cannot run the machine, with the reason.
"""

import os
import shlex
import sys
import time

import boot_list
import machine

HERE = os.path.dirname(os.path.abspath(__file__))
SKIPPED = 77
LONGER = int(os.environ.get("CANSYNC_LONGER", "1"))
LIMIT = 2700 * LONGER  # seconds of this computer, for boot and tests of a course together; what hangs inside ends by the machine's time
PYTHON = "/usr/bin/python3"
PROGRAMS = ("CANSYNC", "CANSYNCD", "CANSYNC_SIM")
# layer2_witnesses_on_vcan_test.py, boot_list.py, hour_test.py
PASSED_ON = ("CANSYNC_WITNESS_FRAMES", "CANSYNC_LONGER", "HOUR_INSTANTS")


def our_programs():
    """Their variables and paths."""
    found = {}
    for name in PROGRAMS:
        if not os.path.exists(os.environ.get(name, "")):
            sys.exit(f"run_machine.py: {name} must be the path of that program; `ctest -L kernel` sets it")
        found[name] = os.path.abspath(os.environ[name])
    return found


def inside(kind, arguments):
    """Command, environment and files of what is to be run inside."""
    environment = {name: os.environ[name] for name in PASSED_ON if name in os.environ}
    if kind == "processes":
        path = os.path.abspath(arguments[0])
        entries = boot_list.read(path)
        unknown = set(arguments[1:]) - {entry.name for entry in entries}
        if unknown:
            sys.exit(f"run_machine.py: {path} has no {', '.join(sorted(unknown))}; it has {' '.join(entry.name for entry in entries)}")
        return [PYTHON, os.path.join(HERE, "boot_list.py"), path, *arguments[1:]], environment, [path, *boot_list.files(entries)]
    programs = our_programs()
    environment |= programs
    files = [*programs.values(), *filter(os.path.isfile, map(os.path.abspath, arguments[1:]))]
    if kind == "tests":
        return [PYTHON, "-B", os.path.join(HERE, "inside.py"), *arguments], environment, files
    return [PYTHON, "-B", os.path.abspath(arguments[0]), *arguments[1:]], environment, files


class Run:
    """What the arguments say, in one course after another: the second one only with what failed in the first, where that is told."""

    def __init__(self, arguments):
        self.arguments = arguments
        self.name = os.path.basename(arguments[1])
        self.begin = time.monotonic()

    def again(self, seed):
        """The command that does this course again."""
        ours = "".join(f"{name}={shlex.quote(os.environ[name])} " for name in (*PROGRAMS, *PASSED_ON) if name in os.environ)
        return f"CANSYNC_SEED={seed} {ours}{shlex.join([PYTHON, '-B', sys.argv[0], *self.arguments])}"

    def show(self, line):
        print(f"{time.monotonic() - self.begin:6.1f} {line}", flush=True)
        if line.startswith("failed: "):
            self.arguments[2:] = line.split()[1:]
            self.name = " ".join(self.arguments[2:])

    def __call__(self, seed):
        """Exit code of what ran inside; None: it did not end."""
        again = self.again(seed)
        command, environment, files = inside(self.arguments[0], self.arguments[1:])
        code = machine.run(command, environment, files, LIMIT, self.show, seed)
        if code is None:
            print(f"run_machine.py: the machine ended without a result, or not within {LIMIT} s")
        if code != 0:
            print(f"run_machine.py: the same course again: {again}")
        return code


def main():
    if len(sys.argv) < 3 or sys.argv[1] not in ("tests", "program", "processes"):
        sys.exit(__doc__)
    try:
        code = machine.in_courses(Run(sys.argv[1:]))
    except machine.Missing as reason:
        print(f"skipped: {reason}")
        sys.exit(SKIPPED)
    sys.exit(1 if code is None else code)


main()
