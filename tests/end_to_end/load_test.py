"""Many clients at once: nobody stays without an answer, and the daemon does not grow. How late it gets is measured by
bench/load, not judged here."""

import os
import sys
import unittest

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "bench"))

from load_run import Clients, Daemon  # noqa: E402

READERS, REQUESTERS, OPEN = 20, 5, 16
SECONDS = 3
# What a client costs in the daemon: readers, writers and their matches; about 120 KiB were seen.
KIB_FOR_A_CLIENT = 512
KIB_FOR_WORK = 4096  # buffers that grow to what the work needs; what leaks a byte a sample or more would not fit


class Load(unittest.TestCase):
    def test_every_request_is_answered_and_the_daemon_does_not_grow(self):
        with Daemon() as daemon:
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


if __name__ == "__main__":
    unittest.main()
