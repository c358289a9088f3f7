"""Where status words come from, and whom both channels ask, as whole processes."""

import os
import re
import sys
import unittest

from gateway import LONG, Gateway, wait_for

BIT_RATE = 250000
INTERVAL = 4  # ms, which follows from it
READ_PERIOD = 100  # ms from one read of the status word to the next
SLAVES = 4


class StatusValue(unittest.TestCase):
    """`slave.status_value`: the simulated drive has its status word in the low word of actual value 5."""

    def test_the_parameter_is_not_read_while_actual_values_bring_the_status_word(self):
        options = ("--set", f"startup.status_period_ms={READ_PERIOD}")
        with Gateway(1, BIT_RATE, "status_value = 5\n", options) as gateway:
            self.gateway = gateway
            values = gateway.start("set", "0=100", "4=1", "--rate", 20)
            try:
                wait_for("actual values come",
                         lambda: any(slave["values"][0]["raw"] is not None for slave in gateway.json("watch", 0, "--count", 1)))
                answers, interval = self.slave()["answers"], self.interval()
                wait_for("40 reads would have been due", lambda: self.interval() > interval + 40 * READ_PERIOD / INTERVAL)
                due, slave = (self.interval() - interval) * INTERVAL / READ_PERIOD, self.slave()
                # Some are read where the writer or the line got no processor time for a while.
                self.assertLess(slave["answers"] - answers, due / 4)
                self.assertEqual((slave["synchronized"], slave["status_word"] & 0x8000), (True, 0x8000))
            finally:
                values.terminate()
                values.communicate(timeout=LONG)
            wait_for("without them it is read", lambda: self.slave()["answers"] > slave["answers"] + 20)

    def interval(self):
        return self.gateway.wait_status("the interval is told", lambda status: status["interval"])["interval"]

    def slave(self):
        return self.gateway.json("slaves")[0]


class PollingApart(unittest.TestCase):
    """`process.polling_apart`: WRC2 asks half a round ahead of WRC1."""

    def test_the_second_channel_asks_half_a_round_ahead(self):
        gateway = Gateway(SLAVES, BIT_RATE, options=("--set", "process.polling_apart=true"))
        trace = os.path.join(gateway.folder.name, "trace")
        gateway.options += ["--set", f"sim.trace={trace}"]
        with gateway:
            gateway.run("set", "0=100", "4=1", "--rate", 20, "--seconds", 1)
            self.assertEqual(gateway.stop(), 0)
            with open(trace, encoding="ascii") as file:
                intervals = file.read().split(" sync 080#\n")
        # A telegram that was left out must not pair one of this interval with one of the next.
        identifiers = [[int(found, 16) for found in re.findall(r" (1[0-9A-F]{2})#", one)] for one in intervals]
        asked = [(of_one[0] & 0x7F, of_one[1] & 0x7F) for of_one in identifiers
                 if len(of_one) == 2 and of_one[0] < 0x180 <= of_one[1]]
        self.assertEqual({first for first, _ in asked}, set(range(SLAVES)))
        self.assertGreater(len(asked), 4 * SLAVES)
        self.assertEqual({(second - first) % SLAVES for first, second in asked}, {SLAVES // 2})


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "-v", *filter(None, sys.argv[1:])])
