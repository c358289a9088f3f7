"""Runs the tests of this folder in the booted machine, in their order, up to the first that fails; says the exit code as
tests/kernel/machine.py wants it, and powers off: in the usual way, which is the last test, or after a failure at once."""

import pathlib
import signal
import subprocess
import sys
import time
import traceback
import unittest

from machine import locks_are_taken, wait_for

MODULES = ("a_installed_test", "b_unknown_lines_test", "c_running_test", "d_power_test", "d_journal_test", "e_packages_test")


def shut_down():
    """A shutdown in the usual way, while the line runs: the daemon has stopped it before systemd stops any unit. Whether that is so."""
    wait_for("the locks of a line in run are taken", locks_are_taken)  # a moment after it is active
    signal.signal(signal.SIGTERM, signal.SIG_IGN)  # this service is stopped, too
    subprocess.run(["systemctl", "poweroff"], check=False, timeout=60)
    deadline = time.monotonic() + 60  # without an answer by then there is none
    while time.monotonic() < deadline:
        text = subprocess.run(["journalctl", "--no-pager", "--boot", "EVENT=daemon_stopping", "EVENT=daemon_stopped"], text=True,
                              stdout=subprocess.PIPE, check=False, timeout=60).stdout.splitlines()
        if text and text[-1].endswith(": stopped") and "the computer shuts down" in text[-2]:
            return True
        time.sleep(0.5)
    print("prove.py: the daemon was not asked to stop before the shutdown:", *text[-4:], sep="\n")
    return False


def main():
    here = pathlib.Path(__file__).parent
    sys.path.insert(0, str(here))
    code = 1
    try:
        suite = unittest.defaultTestLoader.loadTestsFromNames(MODULES)
        # Each test goes on where the one before has left the machine.
        result = unittest.TextTestRunner(stream=sys.stdout, verbosity=2, failfast=True).run(suite)
        code = 0 if result.wasSuccessful() and result.testsRun > 0 else 1
        if code == 0:
            code = 0 if shut_down() else 1
        else:
            subprocess.run(["journalctl", "--no-pager", "--lines=60", "--boot"], check=False, timeout=60)
    except BaseException:  # whatever it is, the machine must end and tell
        traceback.print_exc(file=sys.stdout)
    uptime = pathlib.Path("/proc/uptime").read_text(encoding="ascii").split()[0]
    print(f"exit code {code}, after {uptime} s of its own", flush=True)
    subprocess.run(["systemctl", "poweroff", "--force"], check=False, timeout=60)


main()
