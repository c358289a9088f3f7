"""A limit for each test: what waits for something that never comes ends as a failure, and the others have their turn."""

import signal
import unittest

CASE = 240  # seconds of the machine's own; one case, its setUp included


class WithLimit(unittest.TextTestResult):
    """Ends each case that takes longer than CASE, as a failure that shows where it stood."""

    def startTest(self, test):
        super().startTest(test)
        signal.signal(signal.SIGALRM, lambda *_: test.fail(f"{test.id()} has not ended within {CASE} s"))
        signal.alarm(CASE)

    def stopTest(self, test):
        signal.alarm(0)
        super().stopTest(test)
