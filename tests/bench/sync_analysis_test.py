"""What is calculated from a row of SYNC instants (bench/sync_analysis.py), for rows of which it is known."""

import os
import sys
import unittest

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "bench"))
import sync_analysis  # noqa: E402

INTERVAL = 8_000_000  # ns
EDGES = 1250
START = 1_700_000_000_000_000_000


def grid(late=(), missing=()):
    """Instants on the grid. `late`: how much which of them are late, in ns; `missing`: those that are not there."""
    late = dict(late)
    return [START + slot * INTERVAL + late.get(slot, 0) for slot in range(EDGES) if slot not in missing]


class SyncAnalysis(unittest.TestCase):
    def growth(self, times):
        return sync_analysis.phase_growth(times, INTERVAL)

    def test_the_grid_does_not_move(self):
        self.assertEqual(self.growth(grid()), 0)
        self.assertEqual(sync_analysis.skipped(grid(), INTERVAL), 0)
        self.assertEqual(sync_analysis.bunched(grid(), INTERVAL), 0)

    def test_slots_that_were_skipped_have_passed(self):
        times = grid(missing={3, 500, 501, 502, 1200})
        self.assertEqual(self.growth(times), 0)
        self.assertEqual(sync_analysis.skipped(times, INTERVAL), 5)

    def test_edges_late_by_more_than_half_an_interval_move_nothing(self):
        self.assertEqual(self.growth(grid(late={600: 5_000_000})), 0)
        self.assertEqual(self.growth(grid(late={600: 5_000_000, 700: 4_100_000, 900: 7_000_000}, missing={601})), 0)
        self.assertEqual(self.growth(grid(late={0: 5_000_000})), 0)

    def test_a_timer_that_is_armed_anew_each_time_moves_by_its_lateness_each_time(self):
        times = grid(late={slot: slot * 100_000 for slot in range(EDGES)})  # 15 intervals in all
        self.assertAlmostEqual(self.growth(times), 0.9 * EDGES * 100_000, delta=INTERVAL / 10)
        times = grid(late={slot: -slot * 1_000 for slot in range(EDGES)})
        self.assertAlmostEqual(self.growth(times), -0.9 * EDGES * 1_000, delta=10_000)

    def test_a_step_to_another_phase_stays(self):
        times = grid(late={slot: 3_000_000 for slot in range(700, EDGES)})
        self.assertEqual(self.growth(times), 3_000_000)

    def test_two_edges_in_one_slot(self):
        times = grid(late={600: 4_500_000})
        self.assertEqual(sync_analysis.bunched(times, INTERVAL), 1)
        self.assertEqual(sync_analysis.shortest(times), 3_500_000)


if __name__ == "__main__":
    unittest.main()
