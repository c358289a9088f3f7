"""A test that failed alone runs once more, alone, and the last line tells it.

The kernels of these tests run beside everything else on a machine and may stand still for seconds. One failure may come of
that; what is wrong fails again, and when more than one test fails nothing is repeated.
"""

import signal
import unittest

CASE = 240  # seconds; one case, its setUp included: whatever it waits for, the others have their turn


class WithLimit(unittest.TextTestResult):
    """Ends each case that takes longer than CASE, as a failure that shows where it stood."""

    def startTest(self, test):
        super().startTest(test)
        signal.signal(signal.SIGALRM, lambda *_: test.fail(f"{test.id()} has not ended within {CASE} s"))
        signal.alarm(CASE)

    def stopTest(self, test):
        signal.alarm(0)
        super().stopTest(test)


def name_of(test):
    """What loads the same test anew; for a class or module whose set-up failed: all its tests."""
    name, _, rest = test.id().partition(" ")  # behind the blank: the class whose set-up it was, or the values of a subtest
    return rest.strip("()") if name in ("setUpClass", "tearDownClass", "setUpModule") else name


def run(suite, runner):
    """True when every test has passed, one of them perhaps only when it was repeated."""
    runner.resultclass = WithLimit
    result = runner.run(suite)
    failed = sorted({name_of(test) for test, _ in result.failures + result.errors})
    if result.wasSuccessful() or not failed:
        return result.wasSuccessful() and result.testsRun > 0
    if len(failed) > 1:
        print(f"{len(failed)} tests failed, none was repeated: {', '.join(failed)}", flush=True)
        return False
    print(f"once more, alone: {failed[0]}", flush=True)
    again = runner.run(unittest.defaultTestLoader.loadTestsFromName(failed[0]))
    passed = again.wasSuccessful() and again.testsRun > 0
    print(f"repeated alone, and {'passed' if passed else 'failed again'}: {failed[0]}", flush=True)
    return passed
