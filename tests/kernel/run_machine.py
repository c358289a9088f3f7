"""Boots the machine of machine.py and runs tests of this folder in it, or a program.

    run_machine.py tests FILES [-k PATTERN] ...        FILES as "*_on_vcan_test.py"; the rest goes to unittest
    run_machine.py program PROGRAM [ARGUMENT ...]      a Python program of this folder; paths in its arguments are those of programs

Exit code: that of the tests or the program; 77 when this computer cannot run the machine (with the reason), which is an
error when CANSYNC_KERNEL_TESTS is in the environment: CI must not skip.
"""

import os
import sys
import time

import machine

HERE = os.path.dirname(os.path.abspath(__file__))
SKIPPED = 77
LIMIT = 1500  # seconds of this computer, for boot and tests together
PYTHON = "/usr/bin/python3"
PROGRAMS = ("CANSYNC", "CANSYNCD", "CANSYNC_SIM")
PASSED_ON = ("CANSYNC_WITNESS_FRAMES",)  # layer2_witnesses_on_vcan_test.py


def main():
    if len(sys.argv) < 3 or sys.argv[1] not in ("tests", "program"):
        sys.exit(__doc__)
    environment = {}
    for name in PROGRAMS:
        if not os.path.exists(os.environ.get(name, "")):
            sys.exit(f"run_machine.py: {name} must be the path of that program; `ctest -L kernel` sets it")
        environment[name] = os.path.abspath(os.environ[name])
    programs = [*environment.values(), *filter(os.path.isfile, map(os.path.abspath, sys.argv[3:]))]
    environment |= {name: os.environ[name] for name in PASSED_ON if name in os.environ}
    inside = [PYTHON, "-B", os.path.join(HERE, "inside.py")] if sys.argv[1] == "tests" else [PYTHON, "-B"]
    arguments = sys.argv[2:] if sys.argv[1] == "tests" else [os.path.abspath(sys.argv[2]), *sys.argv[3:]]
    begin = time.monotonic()
    try:
        code = machine.run([*inside, *arguments], environment, programs, LIMIT,
                           lambda line: print(f"{time.monotonic() - begin:6.1f} {line}", flush=True))
    except machine.Missing as reason:
        required = "CANSYNC_KERNEL_TESTS" in os.environ
        print(f"{'cannot run, but CANSYNC_KERNEL_TESTS is set' if required else 'skipped'}: {reason}")
        sys.exit(1 if required else SKIPPED)
    if code is None:
        sys.exit(f"run_machine.py: the machine ended without a result, or not within {LIMIT} s")
    sys.exit(code)


main()
