"""The judge of a line (line_judge.py) finds each violation that is planted into a line without any."""

import unittest

from line_judge import Judge

# 125 kbit/s: an interval of 8000 us. us after the edge, and the frame; the first two intervals set the line up.
SET_UP = [(0, "080#"), (60, "010#FFFFFFFF02010000"), (8000, "080#"), (8060, "505#712D0000"), (8500, "585#012D00800000"),
          (16000, "080#"), (16060, "505#712D0000"), (16500, "585#012D00800000")]
ACTIVE = [(0, "080#"), (300, "585#012D00800000"), (2950, "105#E803000000000000"), (3300, "305#E803000007000000"),
          (5300, "185#E803000000000000"), (5600, "385#0100"), (7600, "505#712D0000")]
INTERVAL = 8000
FIRST = 3  # the interval in which reference values begin


def line(*planted, without=(), intervals=6, late=()):
    """Lines as `candump -L` writes them. `planted`: more frames (interval, us, text); `without`: those that are left out
    (interval, text); `late`: (interval, us) of a SYNC frame after its edge."""
    frames = list(SET_UP)
    for n in range(FIRST, FIRST + intervals):
        frames += [(n * INTERVAL + at + (dict(late).get(n, 0) if text == "080#" else 0), text) for at, text in ACTIVE
                   if (n, text) not in without and not (n == FIRST and text.startswith("585"))]
    frames += [(n * INTERVAL + at, text) for n, at, text in planted]
    return [f"({1700000000 + at // 1000000}.{at % 1000000:06}) vcan0 {text}" for at, text in sorted(frames, key=lambda f: f[0])]


class Judged(unittest.TestCase):
    def wrong(self, *planted, **options):
        return Judge(line(*planted, **options), 125000).wrong

    def one(self, words, *planted, **options):
        found = self.wrong(*planted, **options)
        self.assertEqual(len(found), 1, found)
        self.assertIn(words, found[0])

    def test_a_line_without_violations(self):
        judge = Judge(line(), 125000)
        self.assertEqual(judge.wrong, [])
        self.assertEqual([judge.count[name] for name in ("SYNC", "WRC1", "RDC1", "RDC2", "CC", "RC")], [9, 6, 6, 6, 8, 7])
        self.assertEqual((set(judge.ways[0]), set(judge.ways[1])), ({350}, {300}))

    def test_the_time_of_a_line_counts_and_not_its_place(self):
        lines = line()
        answer = next(i for i, text in enumerate(lines) if " 585#" in text)
        lines[answer - 1], lines[answer] = lines[answer], lines[answer - 1]
        self.assertEqual(Judge(lines, 125000).wrong, [])

    def test_a_slot_counts_from_its_sync_frame(self):
        late = {"late": [(5, 1000)], "without": [(5, "305#E803000007000000")]}
        self.assertEqual(self.wrong((5, 5310, "305#0000"), **late), [])
        self.one("4311 us after the edge", (5, 5311, "305#0000"), **late)

    def test_a_sync_frame_that_is_missing(self):
        self.assertEqual(self.wrong(without=[(5, text) for _, text in ACTIVE if text != "585#012D00800000"] +
                                    [(6, "585#012D00800000")]), [])

    def test_identifiers(self):
        for text in ("7FF#00", "00000305#00", "305#R", "200#0102", "490#00"):
            self.one("no telegram of CANsync", (4, 4000, text))
        for text in ("320#00000000", "3A0#00000000", "520#712D0000", "5A0#012D0000"):
            self.one("there is no slave 32", (4, 4000, text))

    def test_a_number_that_asks_nobody(self):
        others = [(4, text) for text in ("105#E803000000000000", "305#E803000007000000")]
        self.assertEqual(self.wrong((4, 2950, "17F#E803"), without=others), [])
        self.one("not asked", (4, 2950, "17F#E803"), (4, 3300, "305#E803"), without=others)

    def test_lengths(self):
        self.one("7 data bytes on RDC1", (4, 4000, "306#01020304050607"))
        self.one("1 data bytes on RC", (4, 900, "586#01"))
        self.one("7 data bytes on action", (4, 7700, "010#FFFFFFFF020100"))
        self.one("1 data bytes on SYNC", (4, 4000, "080#00"))

    def test_the_masters_order(self):
        self.one("a second one", (4, 5200, "106#E803"))
        self.one("a second one", (4, 7700, "010#FFFFFFFF02010000"))
        self.one("is behind it", (4, 7000, "105#E803"), without=[(4, "105#E803000000000000"), (4, "305#E803000007000000")])

    def test_actual_values_nobody_asked_for(self):
        self.one("not asked", (4, 2000, "305#0000"))
        self.one("not asked", (4, 4000, "305#0000"))
        self.one("not asked", (4, 5700, "385#0000"))
        self.one("not asked", (4, 3100, "305#0000"), without=[(4, "105#E803000000000000"), (4, "305#E803000007000000")])
        self.one("not asked", (4, 3200, "304#0000"), without=[(4, "305#E803000007000000")])

    def test_actual_values_after_their_slot(self):
        self.assertEqual(self.wrong((4, 4310, "305#0000"), without=[(4, "305#E803000007000000")]), [])
        self.one("4311 us after the edge", (4, 4311, "305#0000"), without=[(4, "305#E803000007000000")])
        self.assertEqual(self.wrong((4, 6640, "385#0000"), without=[(4, "385#0100")]), [])
        self.one("6641 us after the edge", (4, 6641, "385#0000"), without=[(4, "385#0100")])

    def test_a_tolerance_widens_the_slots(self):
        lines = line((4, 4410, "305#0000"), (5, 2020, "585#012D00800000"),
                     without=[(4, "305#E803000007000000"), (5, "585#012D00800000")])
        self.assertEqual(Judge(lines, 125000, tolerance=100).wrong, [])
        self.assertEqual(len(Judge(lines, 125000, tolerance=99).wrong), 2)

    def test_two_commands_before_their_answers(self):
        more = ((4, 7900, "505#712D0000"), (5, 400, "585#012D00800000"), (5, 500, "585#012D00800000"))
        found = self.wrong(*more, without=[(5, "585#012D00800000")])
        self.assertEqual([line.split(": ")[1] for line in found], ["a second one in this interval"])
        self.one("no command was there", *more[1:], without=[(5, "585#012D00800000")])

    def test_actual_values_of_the_interval_before(self):
        self.one("not asked", (5, 10, "305#0000"), without=[(4, "305#E803000007000000")])

    def test_responses(self):
        self.one("no command was there", (4, 400, "585#012D00800000"))
        self.one("no command was there", (4, 400, "584#012D00800000"))
        here = [(5, "585#012D00800000")]
        self.one("does not answer", (5, 400, "585#012E00800000"), without=here)
        self.one("does not answer", (5, 400, "585#8000"), without=here)
        self.assertEqual(self.wrong((5, 1920, "585#012D00800000"), without=here), [])
        self.one("1 us after its slot", (5, 1921, "585#012D00800000"), without=here)

    def test_slow_responses(self):
        for at, slow in ((1700, 0), (1701, 1)):
            judge = Judge(line((5, at, "585#012D00800000"), without=[(5, "585#012D00800000")]), 125000)
            self.assertEqual((judge.wrong, len(judge.slow)), ([], slow))

    def test_responses_while_the_line_is_set_up(self):
        early = [(at, text) for at, text in SET_UP if at <= 8060]
        lines = [f"(0.{at:06}) vcan0 {text}" for at, text in early]
        judge = Judge([*lines, "(0.010161) vcan0 585#012D00800000"], 125000)
        self.assertEqual((judge.wrong, len(judge.slow)), ([], 1))
        self.assertEqual(Judge([*lines, "(0.015680) vcan0 585#012D00800000"], 125000).wrong, [])
        self.assertIn("1 us after its slot", Judge([*lines, "(0.015681) vcan0 585#012D00800000"], 125000).wrong[0])

    def test_before_the_first_edge(self):
        found = Judge(["(0.000001) vcan0 505#712D0000", "(0.000002) vcan0 080#"], 125000).wrong
        self.assertEqual(len(found), 1, found)
        self.assertIn("before the first SYNC", found[0])


if __name__ == "__main__":
    unittest.main()
