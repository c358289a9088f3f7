"""Runs inside user-mode-linux as the first process: sets up vcan0, runs the tests, leaves their exit code, powers off."""

import ctypes
import faulthandler
import os
import shlex
import subprocess
import sys
import traceback
import unittest

POWER_OFF = 0x4321FEDC
AGAIN = 2  # further tries of a test that failed


def set_up():
    for module in filter(None, os.environ["MODULE_FILES"].split(":")):
        subprocess.run(["insmod", module], check=True)
    subprocess.run(["ip", "link", "set", "lo", "up"], check=True)
    subprocess.run(["ip", "route", "add", "224.0.0.0/4", "dev", "lo"], check=True)


def fresh(test):
    """The same test anew; a class or module whose set-up failed: all its tests."""
    name, _, rest = test.id().partition(" ")  # behind the blank: the class whose set-up it was, or the values of a subtest
    if name in ("setUpClass", "tearDownClass"):
        name = rest.strip("()")
    return unittest.defaultTestLoader.loadTestsFromName(name)


def run_tests():
    """Runs the tests; those that fail run again, alone. A machine whose processor others use may stand still for
    seconds in one of them; what is wrong fails each time."""
    here = os.path.dirname(os.path.abspath(__file__))
    sys.path[:0] = [here, os.path.join(here, "..", "end_to_end")]
    os.chdir(here)
    arguments = ["kernel", "discover", "-s", here, "-p", "*_test.py", *shlex.split(os.environ["ARGUMENTS"])]
    runner = unittest.TextTestRunner(stream=sys.stdout, verbosity=2)
    result = unittest.main(module=None, argv=arguments, exit=False, testRunner=runner).result
    for _ in range(AGAIN):
        failed = [test for test, _ in result.failures + result.errors]
        if not failed:
            break
        print(f"again, alone: {', '.join(test.id() for test in failed)}", flush=True)
        result = runner.run(unittest.TestSuite(map(fresh, failed)))
    return 0 if result.wasSuccessful() and result.testsRun > 0 else 1


def run_script(output):
    """The program that was given in the place of the tests."""
    subprocess.run(["ip", "link", "add", "dev", "vcan0", "type", "vcan"], check=True)
    subprocess.run(["ip", "link", "set", "vcan0", "up"], check=True)
    command = [sys.executable, "-B", os.environ["SCRIPT"], *shlex.split(os.environ["ARGUMENTS"]), f"{output}/result"]
    return subprocess.run(command, check=False).returncode


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
