"""Runs the tests of this folder in the booted machine, in their order, up to the first that fails; leaves the exit code
in the file that is given and powers off."""

import os
import pathlib
import subprocess
import sys
import traceback
import unittest

MODULES = ("a_installed_test", "b_unknown_lines_test", "c_running_test", "d_journal_test", "e_packages_test")


def main():
    here = pathlib.Path(__file__).parent
    sys.path.insert(0, str(here))
    code = 1
    try:
        suite = unittest.defaultTestLoader.loadTestsFromNames(MODULES)
        # Each test goes on where the one before has left the machine.
        result = unittest.TextTestRunner(stream=sys.stdout, verbosity=2, failfast=True).run(suite)
        code = 0 if result.wasSuccessful() and result.testsRun > 0 else 1
        if code != 0:
            subprocess.run(["journalctl", "--no-pager", "--lines=60", "--boot"], check=False, timeout=60)
    except BaseException:  # whatever it is, the machine must end and tell
        traceback.print_exc(file=sys.stdout)
    sys.stdout.flush()
    pathlib.Path(sys.argv[1]).write_text(str(code), encoding="ascii")
    os.sync()
    subprocess.run(["systemctl", "poweroff", "--force"], check=False, timeout=60)


main()
