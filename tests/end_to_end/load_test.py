"""Many clients at once: nobody stays without an answer, and the daemon does not grow; floods, and clients that are stopped,
killed or slow, cost the others little. How late it gets is measured by bench/load; that control words and reads do not wait
behind those of others, by fair_lanes_test."""

import os
import sys
import unittest

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "bench"))

import flood_run  # noqa: E402
from gateway import BIT_RATE, Gateway  # noqa: E402
from load_run import Clients, Daemon  # noqa: E402

READERS, REQUESTERS, OPEN = 20, 5, 16
SECONDS = 1
FLOOD_SECONDS = 1
ROUNDS = 5  # in which the computer, which others use as well, has time for the daemon at least once
MISHAP_SECONDS = {"stopped": 6, "slow": 6}  # DDS gives up after 5 s who stands still; what a slow one does not take must pile up
OTHER_MISHAP_SECONDS = 2
# What a client costs in the daemon: readers, writers and their matches; about 120 KiB were seen.
KIB_FOR_A_CLIENT = 512
KIB_FOR_WORK = 4096  # buffers that grow to what the work needs; what leaks a byte a sample or more would not fit


class Load(unittest.TestCase):
    def test_every_request_is_answered_and_the_daemon_does_not_grow(self):
        with Daemon(BIT_RATE) as daemon:
            before = daemon.resident()
            clients = Clients(os.environ["LOAD_CLIENTS"], READERS, REQUESTERS, OPEN)
            # Twice: what the first ones needed is there for the second.
            sizes = []
            for _ in range(2):
                with clients.connected(daemon, SECONDS) as process:
                    clients.work(process)
                    found = clients.result(process)
                sizes.append(daemon.resident())
                self.assertEqual(found["clients"], READERS + REQUESTERS, found)
                self.assertGreater(found["requests"], 0, found)
                self.assertEqual(found["done"] + found["queue_full"], found["requests"], found)
                self.assertEqual((found["wrong_values"], found["unanswered"], found["no_reply"]), (0, 0, 0), found)
                self.assertEqual(found["blind"], 0, "readers without any actual value")
                self.assertEqual(found["exit_code"], 0, found)
            self.assertLess(sizes[0], before + (READERS + REQUESTERS) * KIB_FOR_A_CLIENT + KIB_FOR_WORK, sizes)
            self.assertLess(sizes[1], sizes[0] + KIB_FOR_WORK, sizes)
            print(f"resident KiB: before {before}, after each round {sizes}; {found}")

    def test_a_flood_costs_no_control_word_and_only_moments_of_reference_values(self):
        program = os.environ["FLOOD_CLIENTS"]
        found = {}

        def values(name):
            """What became of the reference values of one round; every control word is done in each."""
            found[name] = flood_run.beside(program, daemon, flood_run.FLOODS[name], FLOOD_SECONDS)
            words = found[name]["command"]
            self.assertEqual(words["ends"], {"done": words["requests"]}, name)
            return found[name]["references"]

        def most_are_taken(name):
            """And all are written."""
            of = values(name)
            self.assertEqual(of["ends"].keys(), {"refused"}, name)
            return of["ends"]["refused"] < of["requests"] // 2

        with Gateway(slaves=4) as daemon:
            for name in ("alone", "library"):
                # Moments in which the computer runs nobody may cost values; a flood that goes first costs most of them.
                self.assertTrue(any(most_are_taken(name) for _ in range(ROUNDS)), found)
            # Programs that go around the library take the processors from everybody: what that costs is only measured.
            values("raw parameters")
        print(flood_run.table({"floods": found, "mishaps": {}}))
        flood = found["library"]["others"]
        self.assertEqual(flood["open"], 0, "every request of the library ends")
        self.assertGreater(flood["ends"]["refused here"], 0)
        # What has left the program is within the daemon's limit.
        self.assertNotIn("refused", flood["ends"])
        self.assertNotIn("no_reply", flood["ends"])

    def test_a_client_that_is_stopped_killed_or_slow_keeps_nobody_waiting(self):
        program = os.environ["FLOOD_CLIENTS"]
        found = {}

        def reads(name):
            """How many one round had in a second, each of them done."""
            seconds = MISHAP_SECONDS.get(name, OTHER_MISHAP_SECONDS)
            found[name] = flood_run.mishap(program, daemon, name, seconds)
            reads = found[name]["read"]
            self.assertEqual(reads["ends"], {"done": reads["requests"]}, name)
            return reads["requests"] / seconds

        with Gateway(slaves=4) as daemon:
            alone = reads("none")
            for name in ("stopped", "killed", "slow"):
                # A daemon that waits 100 ms in each write for who takes nothing has time for next to no read in any round.
                self.assertTrue(any(reads(name) > alone / 3 for _ in range(ROUNDS)), found)
        print(flood_run.table({"floods": {}, "mishaps": found}))


if __name__ == "__main__":
    unittest.main()
