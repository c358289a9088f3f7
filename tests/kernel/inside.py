"""Runs inside the machine: the tests of this folder in the files named, with the arguments of unittest behind them."""

import os
import sys
import unittest

import case_limit


def main():
    here = os.path.dirname(os.path.abspath(__file__))
    sys.path[:0] = [here, os.path.join(here, "..", "end_to_end")]
    files, *arguments = sys.argv[1:]
    runner = unittest.TextTestRunner(stream=sys.stdout, verbosity=2, resultclass=case_limit.WithLimit)
    program = unittest.main(module=None, testRunner=runner, exit=False,
                            argv=["kernel", "discover", "-s", here, "-p", files, *arguments])
    # There must be what a test needs.
    sys.exit(0 if program.result.wasSuccessful() and program.result.testsRun > 0 and not program.result.skipped else 1)


main()
