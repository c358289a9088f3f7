"""The code of docs/python.md, and the examples, as they stand there."""

import contextlib
import io
import re
import subprocess
import sys
import threading
import unittest

from line import LONG, PROFILES, ROOT, Line, cansync

EXAMPLES = ROOT / "tools/examples"


class Documents(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.gateway = cls.enterClassContext(Line("--set", "process.poll_without_reference=true"))

    def test_every_block_of_the_document_runs(self):
        text = (ROOT / "docs/python.md").read_text(encoding="utf-8")
        blocks = re.findall(r"^```python\n(.*?)^```", text, re.DOTALL | re.MULTILINE)
        # A whole program is no block; it is run below.
        program = (EXAMPLES / "first_client.py").read_text(encoding="utf-8")
        self.assertIn(f"```py\n{program}```", text)
        self.assertEqual(len(blocks) + 1, len(re.findall(r"^```", text, re.MULTILINE)) // 2)
        here = f'connect("{self.gateway.bus}", domain={self.gateway.domain}, timeout={LONG}, profiles="{PROFILES}")'
        shown = ""
        for block in blocks:
            self.assertIn('connect("can0")', block)
            printed = io.StringIO()
            with self.subTest(block), contextlib.redirect_stdout(printed):
                exec(compile(block.replace('connect("can0")', here), "docs/python.md", "exec"), {"cansync": cansync})
            shown += printed.getvalue()
        for promised in ("100000000 inc/s", "SLAVE_NOT_CONFIGURED daemon: slave 9: not configured; allowed 0..3"):
            self.assertIn(promised, text)
            self.assertIn(promised, shown)

    def start(self, name, bus, *arguments):
        return subprocess.Popen([sys.executable, "-B", EXAMPLES / name, str(self.gateway.domain), bus, *arguments],
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    def finish(self, process, code):
        with process:
            try:
                out, err = process.communicate(timeout=LONG)
            except subprocess.TimeoutExpired:
                process.kill()
                raise
        self.assertEqual(process.returncode, code, err)
        return out, err

    def run_example(self, name, *arguments, code=0):
        return self.finish(self.start(name, self.gateway.bus, *arguments), code)[0]

    def test_the_logger_writes_every_slave(self):
        stop = threading.Event()

        def lead():
            with self.gateway.connect() as line, line.references() as references:
                while not stop.wait(0.1):
                    for telegram in (1, 2):
                        references.give(telegram, [0], release_intervals=1000)

        leading = threading.Thread(target=lead)
        leading.start()
        try:
            head, *rows = self.run_example("data_logger.py", "200").splitlines()
        finally:
            stop.set()
            leading.join(LONG)
        self.assertEqual(head.split(",")[:3], ["receive_time_ns", "slave", "telegrams"])
        self.assertEqual(len(rows), 200)
        self.assertEqual({len(row.split(",")) for row in rows}, {13})
        self.assertEqual({row.split(",")[1] for row in rows}, {"0", "1", "2", "3"})

    def test_the_first_client_reads_shows_and_moves(self):
        status, *shown, moved = self.run_example("first_client.py", "winder").splitlines()
        self.assertRegex(status, "^parameter 301: 0x[0-9A-F]{4}$")
        self.assertEqual(len(shown), 10)
        self.assertGreater(int(moved.removeprefix("value 0 moved by ")), 0)

    def test_the_batch_reads_and_writes(self):
        out = self.run_example("parameter_batch.py", "winder", "403=0x10", "403", "103")
        self.assertEqual(out.splitlines(), ["403=0x10: done", "403 = 16", "103 = 1"])
        out = self.run_example("parameter_batch.py", "9", "1", "1=70000", code=1)
        self.assertEqual([line.split(": ")[1] for line in out.splitlines()], ["daemon", "daemon"])

    def test_without_a_daemon_they_say_so(self):
        # All at once: each looks for 5 s.
        examples = [self.start(name, "nobody", *arguments) for name, *arguments in (
            ("data_logger.py", "1"), ("parameter_batch.py", "1", "1"), ("first_client.py", "1"))]
        for _, err in [self.finish(example, 1) for example in examples]:
            self.assertIn("no daemon found", err)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[1:]])
