"""The verbs of `cansync` that open a job, as processes: parameters and transfers."""

import json
import os
import tempfile
import unittest

from gateway import wait_for
from verb_case import ALWAYS_BUSY, BUSY, BUSY_REPLIES, DATA, DEVICE_TYPE, DOUBLEWORD, LAG, LONGEST_LAG, NOT_AVAILABLE, WORD, VerbTest


class Parameters(VerbTest):
    def test_read(self):
        heading, row = self.text("read", 0, DEVICE_TYPE).splitlines()
        self.assertEqual(heading.split(), ["SLAVE", "NAME", "NUMBER", "PARAMETER", "VALUE", "UNIT", "RAW", "MEANING"])
        self.assertEqual(row.split(), ["0", "slave0", str(DEVICE_TYPE), "-", "4400", "0x1130"])
        self.assertEqual(self.text("read", "winder", "0x65").splitlines()[1].split(), ["1", "winder", "101", "-", "65536", "0x00010000"])
        # One table for a hundred values as for one.
        lines = self.text("read", "0-1", DEVICE_TYPE, "0x65").splitlines()
        self.assertEqual([line.split()[:3] for line in lines[1:]], [[str(slave), name, number] for slave, name in ((0, "slave0"), (1, "winder"))
                                                                    for number in (str(DEVICE_TYPE), "101")])
        self.assertEqual(
            self.one("read", "winder", DEVICE_TYPE, "--format", "word") | {"intervals": 0},
            {"slave": 1, "number": DEVICE_TYPE, "element": 7, "sub_slave": 0, "value": 4400, "signed": 4400}
            | {"format": "word", "error_code": 0, "intervals": 0, "name": None, "unit": None, "scaled": None}
            | {"result": "done", "reason": "", "cause": None},
        )

    def test_write_in_every_notation(self):
        for text, value in [("1500", 1500), ("0xFFFE", 65534), ("-5", 65531), ("-0x10", 65520), ("65535", 65535)]:
            self.run_verb("write", 2, WORD, text)
            self.assertEqual(self.one("read", 2, WORD)["value"], value, text)
        for text, value in [("-5", 4294967291), ("-2147483648", 2147483648), ("0xFFFFFFFF", 4294967295)]:
            self.run_verb("write", 2, DOUBLEWORD, text)
            self.assertEqual(self.one("read", 2, DOUBLEWORD)["value"], value, text)
        self.assertEqual(
            self.text("write", "winder", DOUBLEWORD, "-1", "--format", "doubleword"),
            "4294967295 (0xFFFFFFFF, doubleword, signed -1)\n",
        )

    def test_a_negative_value_that_the_slaves_word_cannot_hold(self):
        self.run_verb("write", 0, WORD, 7)
        self.assertIn("allowed: -32768..65535", self.fails("write", 0, WORD, "-32769", code=2))
        self.assertEqual(self.one("read", 0, WORD)["value"], 7)

    def test_refused(self):
        self.assertIn("allowed 0..3", self.fails("read", 9, DEVICE_TYPE, code=3))
        refused = self.one("write", 0, WORD, 1, "--element", 0, code=3)
        self.assertEqual((refused["result"], refused["value"]), ("refused", None))
        self.assertIn("element", refused["reason"])

    def test_unknown_name(self):
        self.assertIn("winder", self.fails("read", "unwinder", DEVICE_TYPE, code=2))

    def test_slave_errors(self):
        error = self.one("read", 0, 77, code=4)
        self.assertEqual((error["result"], error["error_code"], error["value"]), ("slave_error", 0xFFFB, None))
        self.assertIn("0xFFFB", self.fails("read", 0, 77, code=4))
        self.assertEqual(self.one("read", 0, NOT_AVAILABLE, code=4)["error_code"], 0xFFFA)
        self.assertEqual(self.one("write", 0, DEVICE_TYPE, 1, code=4)["error_code"], 0xFFFC)
        self.assertEqual(self.one("read", 0, DEVICE_TYPE, "--format", "doubleword", code=4)["result"], "word_expected")
        self.assertEqual(self.one("read", 0, DOUBLEWORD, "--format", "word", code=4)["result"], "doubleword_expected")
        self.assertEqual(self.one("write", 0, WORD, 70000, code=4)["result"], "value_too_wide")

    def test_busy_for_a_while(self):
        self.run_verb("write", 3, BUSY_REPLIES, 5)
        answer = self.one("read", 3, BUSY)
        self.assertEqual(answer["value"], 410)
        # Six telegrams, one an interval: the last is answered five intervals after the first, or in the next one.
        self.assertGreaterEqual(answer["intervals"], 5)

    def test_busy_for_ever_ends_with_the_monitoring_time(self):
        self.run_verb("write", 3, BUSY_REPLIES, ALWAYS_BUSY)
        self.addCleanup(self.run_verb, "write", 3, BUSY_REPLIES, 0)
        self.assertEqual(self.one("read", 3, BUSY, "--timeout", 0.3, code=5)["result"], "timeout")
        self.assertIn("slave 3, parameter 410", self.fails("read", 3, BUSY, "--timeout", 0.3, code=5))

    def test_ctrl_c_cancels_the_job_of_a_busy_slave(self):
        self.run_verb("write", 3, BUSY_REPLIES, ALWAYS_BUSY)
        self.addCleanup(self.run_verb, "write", 3, BUSY_REPLIES, 0)
        process = self.gateway.start_job("open_parameter_jobs", "read", 3, BUSY, "--timeout", 3000, "--json")
        out, _ = self.interrupt(process, code=7)
        self.assertEqual(json.loads(out)["result"], "cancelled")
        self.gateway.wait_status("no job is open", lambda status: status["open_parameter_jobs"] == 0)
        # A write that the drive has is not cancelled; without a format it is asked for that first.
        process = self.gateway.start_job("open_parameter_jobs", "write", 3, BUSY, 9, "--format", "word", "--timeout", 3000, "--json")
        out, _ = self.interrupt(process, code=5)
        ended = json.loads(out)
        self.assertEqual(ended["result"], "no_answer")
        self.assertIn("the slave has taken the value", ended["reason"])
        self.gateway.wait_status("no job is open", lambda status: status["open_parameter_jobs"] == 0)

    def failed_writes(self):
        return [event["text"] for event in self.json("events") if event["code"] == "request_failed"]

    def test_what_is_to_be_done_after_a_write_that_failed(self):
        before = len(self.failed_writes())
        self.run_verb("write", 3, BUSY_REPLIES, ALWAYS_BUSY)
        self.assertEqual(self.one("write", 3, BUSY, 21, "--format", "word", "--timeout", 0.3, code=5)["result"], "timeout")
        self.run_verb("write", 3, BUSY_REPLIES, 0)
        self.assertEqual(self.one("read", 3, BUSY)["value"], BUSY, "the drive has not got it")
        self.run_verb("write", 3, BUSY, 21)
        self.addCleanup(self.run_verb, "write", 3, BUSY, BUSY)
        self.assertEqual(self.one("read", 3, BUSY)["value"], 21)
        for _ in range(2):
            self.assertEqual(self.one("write", 3, LAG, LONGEST_LAG + 1, code=4)["result"], "slave_error")
        self.run_verb("write", 3, LAG, LONGEST_LAG)
        self.assertEqual(self.one("read", 3, LAG)["value"], LONGEST_LAG)
        wait_for("each is told", lambda: len(self.failed_writes()) == before + 3)


class Transfers(VerbTest):
    BIT_RATE = 1000000

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.folder = cls.enterClassContext(tempfile.TemporaryDirectory())

    def path(self, name, data=None):
        path = os.path.join(self.folder, name)
        if data is not None:
            with open(path, "wb") as file:
                file.write(data)
        return path

    def content(self, name):
        with open(self.path(name), "rb") as file:
            return file.read()

    def test_64_kib_there_and_back_are_identical(self):
        data = os.urandom(65536)
        done = self.one("download", "winder", DATA, self.path("in", data))
        self.assertEqual((done["bytes"], done["result"]), (65536, "done"))
        self.run_verb("upload", "winder", hex(DATA), 65536, self.path("out"))
        self.assertEqual(self.content("out"), data)

    def test_a_transfer_says_how_long_it_took(self):
        for done in (
            self.one("download", "winder", DATA, self.path("timed", os.urandom(3000))),
            self.one("upload", "winder", DATA, 3000, self.path("timed_back")),
        ):
            self.assertGreater(done["intervals"], 10)
            self.assertAlmostEqual(done["seconds"], done["intervals"] / 1000)

    def test_standard_input_and_output(self):
        data = os.urandom(1001)
        self.run_verb("download", 2, DATA, "-", "--block-size", 60, data=data)
        self.assertEqual(self.run_verb("upload", 2, DATA, 1001, "-").stdout, data)

    def test_a_refused_upload_leaves_the_file_as_it_was(self):
        path = self.path("kept", b"before")
        self.assertIn("address", self.fails("upload", 0, 0x10, 100, path, code=3))
        self.assertEqual(self.content("kept"), b"before")
        self.assertEqual([name for name in os.listdir(self.folder) if name.startswith("kept")], ["kept"])

    def test_slave_error(self):
        beyond = 0x00F00000
        failed = self.one("download", 0, beyond, self.path("small", b"123456"), code=4)
        self.assertEqual((failed["result"], failed["error_code"], failed["bytes"]), ("slave_error", 0x0105, 0))

    def test_a_folder_that_is_missing_is_told_before_the_bus_is_used(self):
        self.fails("upload", 0, DATA, 100, self.path("missing/file"), code=1)
        self.fails("download", 0, DATA, self.path("missing"), code=1)

    def test_ctrl_c_cancels_a_long_upload(self):
        process = self.gateway.start_job("open_transfers", "upload", 1, DATA, 1000000, self.path("cut"), "--json")
        out, err = self.interrupt(process, code=7)
        self.assertEqual(json.loads(out)["result"], "cancelled")
        self.assertIn("upload at 0x100", err)
        self.assertEqual([name for name in os.listdir(self.folder) if name.startswith("cut")], [])
        self.gateway.wait_status("no transfer is open", lambda status: status["open_transfers"] == 0)
        self.run_verb("upload", 1, DATA, 600, self.path("after"))
        self.assertEqual(len(self.content("after")), 600)

    def test_the_progress_bar_is_for_terminals_alone(self):
        shown, code = self.gateway.run_on_terminal("upload", 0, DATA, 3000, self.path("bar"))
        self.assertEqual(code, 0, shown)
        self.assertRegex(shown, r"\r\x1b\[K\[#*\.*\] +\d+ %  \d+ of 3000 B")
        self.assertRegex(self.run_verb("upload", 0, DATA, 3000, self.path("bar")).stderr, r"^cansync: 3000 bytes in \d+ intervals, \d+\.\d{3} s, \d+ bytes/s\n$")


if __name__ == "__main__":
    unittest.main(verbosity=2)
