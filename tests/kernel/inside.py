"""Runs inside user-mode-linux as the first process: sets up vcan0, runs the tests, leaves their exit code, powers off."""

import ctypes
import faulthandler
import os
import shlex
import subprocess
import sys
import traceback
import unittest

import once_more

POWER_OFF = 0x4321FEDC
LONG = 90  # seconds; one command


def set_up():
    for module in filter(None, os.environ["MODULE_FILES"].split(":")):
        subprocess.run(["insmod", module], check=True, timeout=LONG)
    subprocess.run(["ip", "link", "set", "lo", "up"], check=True, timeout=LONG)
    subprocess.run(["ip", "route", "add", "224.0.0.0/4", "dev", "lo"], check=True, timeout=LONG)


class Choice(unittest.TestProgram):
    """Finds the tests by the arguments of unittest's own program, and does not run them."""

    def __init__(self, arguments):
        super().__init__(module=None, argv=arguments)

    def runTests(self):  # noqa: N802: unittest's name
        pass


def run_tests():
    """Runs the tests of this folder that the arguments choose; the exit code."""
    here = os.path.dirname(os.path.abspath(__file__))
    sys.path[:0] = [here, os.path.join(here, "..", "end_to_end")]
    os.chdir(here)
    arguments = ["kernel", "discover", "-s", here, "-p", "*_test.py", *shlex.split(os.environ["ARGUMENTS"])]
    chosen = Choice(arguments).test
    return 0 if once_more.run(chosen, unittest.TextTestRunner(stream=sys.stdout, verbosity=2)) else 1


def run_script(output):
    """The program that was given in the place of the tests."""
    subprocess.run(["ip", "link", "add", "dev", "vcan0", "type", "vcan"], check=True, timeout=LONG)
    subprocess.run(["ip", "link", "set", "vcan0", "up"], check=True, timeout=LONG)
    command = [sys.executable, "-B", os.environ["SCRIPT"], *shlex.split(os.environ["ARGUMENTS"]), f"{output}/result"]
    return subprocess.run(command, check=False, timeout=int(os.environ["LIMIT"])).returncode


def main():
    code = 1
    try:
        # Once, shortly before the end: where the tests are. It looks at a running program from outside, which may crash it.
        faulthandler.dump_traceback_later(int(os.environ["LIMIT"]) - 20, file=sys.stdout)
        set_up()
        code = run_script(sys.argv[1]) if os.environ["SCRIPT"] else run_tests()
    except BaseException:  # whatever it is, the kernel must end and tell
        traceback.print_exc(file=sys.stdout)
    sys.stdout.flush()
    with open(os.path.join(sys.argv[1], "exit_code"), "w", encoding="ascii") as file:
        file.write(str(code))
    os.sync()
    ctypes.CDLL(None).reboot(POWER_OFF)


main()
