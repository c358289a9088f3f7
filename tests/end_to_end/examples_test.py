"""The programs of tools/examples, against a daemon with simulated drives, whose paths come from EXAMPLES; tools/demo ends on each
signal, also when it runs in the background, and leaves no process."""

import os
import re
import signal
import subprocess
import sys
import unittest

from gateway import CANSYNC, LONG, NEVER_MISSING_REFERENCES, Gateway, wait_for

EXAMPLES = os.environ["EXAMPLES"]
ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
# The folder of the build: CANSYNC is BUILD/tools/cli/cansync.
BUILD = os.path.abspath(os.path.join(os.path.dirname(CANSYNC), "..", ".."))


def processes_of(session):
    """Living processes of a session, each as its number and name."""
    found = []
    for number in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{number}/stat", encoding="utf-8") as file:
                name, rest = file.read().rsplit(")", 1)
        except OSError:
            continue
        state, _, _, its_session = rest.split()[:4]
        if int(its_session) == session and state != "Z":
            found.append((int(number), name.split("(", 1)[1]))
    return found


def ignore_interrupts():
    """As a shell does for what it starts in the background."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


class Examples(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        options = ("--set", "dds.interval_topic=true", "--set", "process.poll_without_reference=true", *NEVER_MISSING_REFERENCES)
        cls.gateway = cls.enterClassContext(Gateway(slaves=3, options=options))

    def start(self, name, *arguments, bus=None):
        place = (str(self.gateway.domain), bus or self.gateway.bus)
        return subprocess.Popen(
            [os.path.join(EXAMPLES, "example_" + name), *place, *map(str, arguments)],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )

    def finish(self, process, code=0):
        """What it printed."""
        try:
            out, err = process.communicate(timeout=LONG)
        except subprocess.TimeoutExpired:
            process.kill()
            raise
        self.assertEqual(process.returncode, code, f"{out}\n{err}\n{self.gateway.log_text()}")
        return out

    def run_example(self, name, *arguments, code=0):
        return self.finish(self.start(name, *arguments), code)

    def position(self, slave):
        return self.gateway.json("read", slave, 310)[0]["value"]

    def test_lead_axis_moves_every_follower(self):
        before = [self.position(slave) for slave in range(3)]
        # Its values are 8 ms ahead; on a machine that stalls it takes a while until some arrive in time.
        leading = self.moving()
        for slave in range(3):
            self.wait_while(leading, f"drive {slave} moves", lambda n=slave: self.position(n) != before[n])
        leading.kill()
        # Until its loss is noticed a writer of the same strength is refused.
        self.gateway.wait_status("nobody gives them", lambda status: not status["reference_release"][0]["writer"])
        out = self.run_example("lead_axis", 300, 1)
        self.assertEqual(re.findall(r"^slave (\d): -?\d+ increments behind$", out, re.MULTILINE), ["0", "1", "2"])

    def test_first_clients_read_show_and_move(self):
        for name in ("first_client", "first_client_c"):
            with self.subTest(name):
                status, *shown, moved = self.run_example(name, 1).splitlines()
                self.assertRegex(status, "^parameter 301: 0x[0-9A-F]{4}$")
                self.assertEqual(len(shown), 10)
                for line in shown:
                    self.assertRegex(line, r"^value 0: -?\d+, in its unit: \S+$")
                self.assertGreater(int(moved.removeprefix("value 0 moved by ")), 0)

    def test_first_clients_take_no_slave_for_another(self):
        for name in ("first_client", "first_client_c"):
            for slave in ("256", "nobody"):
                process = self.start(name, slave)
                self.assertEqual(self.finish(process, code=1), "")

    def test_first_clients_stand_in_their_page(self):
        with open(os.path.join(ROOT, "docs", "client-library.md"), encoding="utf-8") as file:
            page = file.read()
        for name in ("first_client.cpp", "first_client.c"):
            with open(os.path.join(ROOT, "tools", "examples", name), encoding="utf-8") as file:
                self.assertIn("\n" + file.read() + "```", page, f"the page shows another {name}")

    def test_parameter_batch_reads_and_writes(self):
        out = self.run_example("parameter_batch", 1, "1000=4711", "103", "1000", "0x3E9=0x10")
        self.assertEqual(out.splitlines(), ["1000 <- 4711", "103 = 1", "1000 = 4711", "1001 <- 16"])
        self.assertEqual(self.gateway.json("read", 1, 1001)[0]["value"], 16)

    def test_parameter_batch_says_who_refused(self):
        out = self.run_example("parameter_batch", 1, "103=5", "5000", "103", code=1)
        lines = out.splitlines()
        self.assertTrue(lines[0].startswith("103 failed: slave: "), out)
        self.assertTrue(lines[1].startswith("5000 failed: daemon: number 5000: out of range"), out)
        self.assertEqual(lines[2], "103 = 1")
        self.run_example("parameter_batch", 1, "x", code=2)

    def moving(self):
        """A lead axis that gives reference values, so that actual values come, until the test is over."""
        process = self.start("lead_axis", 60, 1000)
        self.addCleanup(process.communicate, timeout=LONG)
        self.addCleanup(process.kill)
        return process

    def wait_while(self, process, what, condition):
        """Waits for `condition` while `process` lives."""

        def look():
            if process.poll() is not None:
                self.fail(f"{process.args} has ended before {what}: {process.communicate(timeout=LONG)}")
            return condition()

        return wait_for(what, look)

    def test_data_logger_writes_every_slave(self):
        self.moving()
        out = self.run_example("data_logger", 300)
        head, *rows = out.splitlines()
        self.assertEqual(head.split(",")[:3], ["receive_time_ns", "slave", "telegrams"])
        self.assertEqual(len(rows), 300)
        cells = [row.split(",") for row in rows]
        self.assertEqual({len(row) for row in cells}, {13})
        self.assertEqual({row[1] for row in cells}, {"0", "1", "2"})

    def test_ros_style_consumer_spins(self):
        self.wait_while(self.moving(), "the drives move", lambda: self.position(1) != self.position(1))
        out = self.run_example("ros_style_consumer", 5)
        lines = out.splitlines()
        self.assertEqual(len(lines), 5)
        for line in lines:
            self.assertRegex(line, r"^joint_states:( -?\d+\.\d{3}){3}$")

    def test_actual_values_in_c_without_the_library(self):
        self.moving()
        out = self.run_example("actual_values", 2, 103)
        self.assertIn("value 7: raw 0x", out)
        self.assertEqual(out.splitlines()[-1], "parameter 103: 2")

    def test_without_a_daemon_every_example_says_where_it_looked(self):
        # All at once: each looks for seconds.
        started = [
            self.start(name, *arguments, bus="nobody")
            for name, *arguments in (
                ("first_client", 1),
                ("first_client_c", 1),
                ("lead_axis", 60, 1),
                ("parameter_batch", 1, 103),
                ("data_logger", 1),
                ("ros_style_consumer", 1),
            )
        ]
        for process in started:
            self.addCleanup(process.kill)
        for process in started:
            err = process.communicate(timeout=LONG)[1]
            self.assertEqual(process.returncode, 1, f"{process.args}: {err}")
            self.assertIn("partition nobody", err)


class Demo(unittest.TestCase):
    def ends_on(self, number, form, shows):
        """`number`: the signal that ends it; None: it ends automatically."""
        with subprocess.Popen(["tools/demo", *form], cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True,
                              preexec_fn=ignore_interrupts, env=dict(os.environ, DEMO_BUILD=BUILD)) as demo:
            try:
                shown = b""
                while shows not in shown:
                    line = demo.stdout.readline()
                    self.assertTrue(line, shown.decode())
                    shown += line
                if number is not None:
                    demo.send_signal(number)
                # Its programs may write on, and hold the pipe: what counts is that all of them end.
                self.assertEqual(demo.wait(LONG), 0, shown.decode())
                wait_for("no process is left", lambda: not processes_of(demo.pid))
            finally:
                for process, _ in processes_of(demo.pid):
                    os.kill(process, signal.SIGKILL)

    def test_ends_on_ctrl_c_while_it_watches(self):
        self.ends_on(signal.SIGINT, ["--layer2"], b"The living bus")

    def test_ends_with_its_seconds_and_leaves_no_process(self):
        self.ends_on(None, ["--j1939", "--seconds", "1"], b"The living bus")

    def test_ends_on_sigterm_before_the_daemon_is_up(self):
        self.ends_on(signal.SIGTERM, [], b"Starting the daemon")

    def test_ends_on_sighup_while_it_watches(self):
        self.ends_on(signal.SIGHUP, [], b"A lead axis gives")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "-v", *sys.argv[1:]])
