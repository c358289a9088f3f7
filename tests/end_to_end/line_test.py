"""A full line of 32 simulated drives at every bit rate, as processes."""

import unittest

from gateway import ACTIVE, wait_for
from verb_case import DEVICE_TYPE, DOUBLEWORD, VerbTest


class Line:
    """32 drives at one bit rate; the classes below name the rate."""

    SLAVES = 32

    def test_all_slaves_are_there(self):
        self.assertEqual([slave["slave"] for slave in self.synchronized_slaves()], list(range(32)))
        status = self.one("status")
        self.assertEqual((status["bit_rate"], status["option_status"]), (self.BIT_RATE, ACTIVE))
        self.assertEqual(status["bit_rate"] * status["interval_length_ns"], 10**12)
        self.assertRegex(self.text("status"), r"(?m)^slaves responding +0-31 \(32 of 32\)$")

    def test_the_highest_slave(self):
        self.assertEqual(self.one("read", 31, DEVICE_TYPE)["value"], 4400)
        self.run_verb("write", "slave31", DOUBLEWORD, 3100000)
        self.assertEqual(self.one("read", 31, DOUBLEWORD)["value"], 3100000)

    def test_every_slave_follows_its_reference_value(self):
        def look():
            self.run_verb("broadcast", "--yes", "--slaves", "all", "--command", 1, "--word", "0x87")  # acknowledges faults
            rows = self.json("watch", "--count", 1)
            # On a loaded machine telegrams are left out, so a slave's turn may come only with the next round.
            every = all(row["values"] and None not in row["intervals"] for row in rows)
            return len(rows) == 32 and every and all(row["values"][0]["raw"] == 1234 for row in rows)

        process = self.gateway.start("set", "0=1234", "4=1")
        try:
            wait_for("all stand at 1234, told by both telegrams", look)
        finally:
            self.interrupt(process, code=0)


class Line1M(Line, VerbTest):
    BIT_RATE = 1000000


class Line500k(Line, VerbTest):
    BIT_RATE = 500000


class Line250k(Line, VerbTest):
    BIT_RATE = 250000


class Line125k(Line, VerbTest):
    BIT_RATE = 125000


if __name__ == "__main__":
    unittest.main(verbosity=2)
