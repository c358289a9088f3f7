"""`scan` and `learn` on a CAN interface of a real kernel: lines that nobody knows, and one whose master runs."""

import json
import subprocess
import unittest

from canline import INTERFACE, LONG, Line, create_interface
from gateway import CANSYNC
from unknown_line import RATES, run_line


def objects(*arguments, code=0):
    """What `cansync` writes with --json."""
    result = subprocess.run([CANSYNC, *map(str, arguments), "--json"], capture_output=True, text=True, timeout=LONG, check=False)
    if result.returncode != code:
        raise AssertionError(f"{arguments}: {result.returncode}\n{result.stdout}{result.stderr}")
    return [json.loads(line) for line in result.stdout.splitlines()], result.stderr


class UnknownLines(unittest.TestCase):
    def test_random_lines_are_found_set_up_and_read_in_engineering_units(self):
        for seed, rate in enumerate(RATES, 1):  # more by hand: unknown_line.py
            with self.subTest(seed=seed, rate=rate):
                create_interface()
                self.assertLess(run_line(seed, (rate,))["all"], 180)


class RunningLine(Line):
    def test_scan_hears_the_master_and_asks_nothing(self):
        found, _ = objects("scan", INTERFACE, "--seconds", 1)
        points = {one["point"]: one["found"] for one in found if one["kind"] == "point"}
        self.assertEqual((points["master"], points["bit rate"]), ("yes", "125000 bit/s"))
        self.assertEqual([one["slave"] for one in found if one["kind"] == "slave"], [0, 1, 2, 3])
        found, told = objects("scan", INTERFACE, "--seconds", 1, "--ask", "--yes", code=1)
        self.assertIn("a master is heard, so nothing is asked", told)
        self.assertEqual([one for one in found if one["kind"] == "answer"], [])

    def test_learn_listens_to_an_interface(self):
        found, _ = objects("learn", INTERFACE, "--seconds", 3)
        points = {one["point"]: one["found"] for one in found if one["kind"] == "point"}
        self.assertEqual((points["bus.bit_rate"], points["slaves"]), ("125000 bit/s", "0-3"))
