"""What the benchmarks measure still starts and is found: the daemon on a bus that answers at once, a scene of the network, the
yardsticks that write samples.

BUILD: the build folder.
"""

import json
import os
import subprocess
import sys
import tempfile
import unittest

SOURCE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
sys.path[:0] = [os.path.join(SOURCE, "bench"), os.path.join(SOURCE, "tests", "end_to_end")]

import network_run  # noqa: E402: found on the path that was set above
from gateway import LONG, Place, end, wait_for  # noqa: E402

BUILD = os.environ["BUILD"]


def end_by_kill(process):
    process.kill()
    process.wait(LONG)


class Daemons(unittest.TestCase):
    def test_the_daemon_on_a_bus_that_answers_at_once_is_found_and_runs(self):
        place = Place()
        with tempfile.NamedTemporaryFile("w", suffix=".toml") as file:
            file.write(f'[bus]\nname = "{place.bus}"\nbit_rate = 125000\n[realtime]\nmode = "ignore"\npriority = 0\n'
                       f"[dds]\ndomain = {place.domain}\n[[slave]]\nnumber = 0\n")
            file.flush()
            daemon = subprocess.Popen([f"{BUILD}/bench/gateway_bench", file.name], stderr=subprocess.DEVNULL)
            self.addCleanup(end, daemon)
            wait_for("it runs", lambda: b"on 'run'" in place.run("events").stdout, LONG)

    def test_the_yardsticks_writers_are_heard(self):
        for program, writer in (("dds_latency", "write"), ("frames_bench", "bridge")):
            with self.subTest(program=program):
                place = Place()
                path = f"{BUILD}/bench/{program}"
                writing = subprocess.Popen([path, writer, str(place.domain), place.bus, str(LONG)], stdout=subprocess.DEVNULL)
                self.addCleanup(end_by_kill, writing)
                wait_for("samples come", lambda: self.heard([path, "listen", str(place.domain), place.bus, "1"]), LONG)

    @staticmethod
    def heard(command):
        """What `dds_latency` and `frames_bench` print of samples that came."""
        shown = subprocess.run(command, capture_output=True, text=True, check=False, timeout=LONG).stdout
        return shown and (not shown.startswith("{") or json.loads(shown)["frames"] > 0)

    def test_a_scene_of_the_network_is_measured(self):
        build = network_run.Build("now", BUILD)
        found = network_run.run([build], [(1, 1, 0)], seconds=1, asked=1)[("now", 1, 1, 0)]
        self.assertEqual(found["status_failed"], 0)
        self.assertGreater(found["daemons_cpu_percent"], 0)

    def test_uploads_of_several_clients_are_measured(self):
        found = network_run.run_uploads([network_run.Build("now", BUILD)], 2, 100)[("now", 1, 1, 2)]
        self.assertEqual(found["uploads_failed"], 0)
        self.assertGreater(found["lo_bytes_per_byte"], 1)
        self.assertGreater(found["client_cpu_ms"], 0)


if __name__ == "__main__":
    unittest.main()
