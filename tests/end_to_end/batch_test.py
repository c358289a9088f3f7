"""Batches of `cansync`: lines, variables, expectations, and how they end."""

import json
import os
import signal
import tempfile
import unittest

from gateway import LONG
from names_test import PROFILE
from script_test import Running, Script
from verb_case import DATA, DEVICE_TYPE, DOUBLEWORD, NOT_AVAILABLE, WORD


class Batch(Script):
    @classmethod
    def setUpClass(cls):
        cls.other = os.path.join(cls.enterClassContext(tempfile.TemporaryDirectory()), "other.toml")
        with open(PROFILE, encoding="utf-8") as file:
            text = file.read().replace('name = "torque-offset"\nformat = "word"', 'name = "torque-offset"\nformat = "doubleword"')
        with open(cls.other, "w", encoding="utf-8") as file:
            file.write(text.replace('name = "simulated-drive"', 'name = "other"'))
        cls.OPTIONS = ("--set", f"slave.0.profile={PROFILE}", "--set", f"slave.3.profile={cls.other}")
        super().setUpClass()

    def batch(self, text, *options, code=0):
        return self.run_verb("batch", self.file("batch", text), *options, code=code)

    def test_a_line_is_a_command(self):
        result = self.batch(f"# first\n\nwrite 1 {WORD} 7   # a comment\n  read 'winder' \"{WORD}\"\r\nread 0-1 {DEVICE_TYPE} --json\n")
        lines = result.stdout.decode().splitlines()
        self.assertEqual((lines[0], lines[2].split()), ("7 (0x0007, word)", ["1", "winder", str(WORD), "-", "7", "0x0007"]))
        self.assertEqual([json.loads(line)["slave"] for line in lines[3:]], [0, 1])

    def test_variables_sleep_and_expect(self):
        text = f"PLACE={WORD}\nwrite $WHO $PLACE 31\nsleep 0.05\nexpect 0 read ${{WHO}} ${{PLACE}}\nexpect 3 read 9 1\n"
        lines = self.batch(text, "WHO=winder").stdout.decode().splitlines()
        self.assertEqual((lines[0], lines[2].split()[-2:]), ("31 (0x001F, word)", ["31", "0x001F"]))
        wrong = self.batch(f"expect 0 read 9 1\nwrite 0 {WORD} 32\n", code=1).stderr
        self.assertIn("expected exit status 0, found 3", wrong)
        for line, text in (("read $WHO 1", "found '$WHO', which was not set"), ("sleep x", "SECONDS"), ("expect x status", "STATUS"),
                           ("expect 0 batch y", "every other verb"), ("write all 1 2", "add --yes")):
            self.assertIn(text, self.batch(f"write 0 {WORD} 33\n{line}\n", code=2).stderr)
        self.assertNotIn(self.one("read", 0, WORD)["value"], (32, 33))

    def test_expectations_of_parameters(self):
        self.run_verb("write", 0, "torque-offset", "-12.3")
        self.run_verb("write", 1, WORD, 500)
        self.batch(f"expect read 0 torque-offset = -12.3\nexpect read 0 403 '<=' -123\nexpect read winder {WORD} '>' 499\n")
        for line, found, code in (("read 0 torque-offset '>' 5", "expected of slave 0: torque-offset > 5; found: -12.3 %", 1),
                                  (f"read winder {WORD} != 500 within 0.2", f"expected of slave winder: {WORD} != 500 within 0.2 s; "
                                   "found: 500", 1),
                                  (f"read 1 {NOT_AVAILABLE} = 0", f"expected of slave 1: {NOT_AVAILABLE} = 0; found: ", 4)):
            told = self.batch(f"expect {line}\nwrite 1 {WORD} 501\n", code=code).stderr
            self.assertIn(f"cansync: {self.path('batch')}:1: {found}", told)
        self.assertEqual(self.one("read", 1, WORD)["value"], 500, "the batch ended with the line")

    def test_a_value_of_another_format_than_in_the_profile_meets_nothing(self):
        told = self.batch("expect read 3 torque-offset '>' -1 within 60\n", code=1).stderr
        self.assertIn("found: 0 as a word, but its profile says doubleword: its unit is not known", told)
        self.batch("expect read 3 403 '>' -1\n")

    def test_an_expectation_may_come_true(self):
        self.run_verb("write", 2, WORD, 1)
        running = Running(self.gateway, "batch", self.file("batch", f"expect read 2 {WORD} = 2 within {LONG}\nread 2 {WORD}\n"))
        self.run_verb("write", 2, WORD, 2)
        code, out = running.end()
        self.assertEqual((code, out.split()[-2:]), (0, ["2", "0x0002"]))

    def test_expectations_of_actual_values(self):
        with self.gateway.start("set", "0=1000") as writer:
            self.addCleanup(writer.kill)
            self.batch(f"expect value winder position '>' 0.5 within {LONG}\nexpect value 1 0 '>=' 500\n")
            told = self.batch(f"expect value winder position '<' 0\nwrite 1 {WORD} 502\n", code=1).stderr
            self.assertRegex(told, "batch:1: expected of slave winder: position < 0; found: position is [0-9.]+ mm")
            writer.send_signal(signal.SIGINT)
        self.assertNotEqual(self.one("read", 1, WORD)["value"], 502)

    def test_a_malformed_expectation_is_told_with_its_place(self):
        wrong = {"expect read 0 1000 => 1": 20, "expect value winder position > x": 32, "expect read 0 4096 = 1": 15,
                 "expect value winder": 14, "expect read 0 1000 = 1 within soon": 31, "expect": 1, "expect values 1": 8}
        told = self.batch(f"write 0 {WORD} 34\n" + "".join(line + "\n" for line in wrong), code=2).stderr
        for number, (line, column) in enumerate(wrong.items(), 2):
            self.assertIn(f"cansync: {self.path('batch')}:{number}:{column}: ", told, line)
        self.assertNotEqual(self.one("read", 0, WORD)["value"], 34)

    def test_all_lines_share_one_connection(self):
        def participants():
            return {event["participant"] for event in self.json("events") if event.get("action") == "parameter_write"}

        before = participants()
        self.batch("".join(f"write 0 {WORD} {n}\n" for n in range(20)))
        self.assertEqual(len(participants() - before), 1)

    def test_a_wrong_line_is_told_with_its_place_and_nothing_is_sent(self):
        self.run_verb("write", 0, WORD, 1)
        wrong = {"write 0 1000 99999 --format word": 14, "write 0 99999 1": 9, "nosuch 1": 1, "read 0": 1, "read 'x": 6,
                 " status --domain 3": 9, "batch other": 1, "control 0-40 1": 9, "wait soon": 6, "write 0 1 2 3": 13}
        text = f"write 0 {WORD} 2\n" + "".join(line + "\n" for line in wrong)
        told = self.batch(text, code=2).stderr
        for number, (line, column) in enumerate(wrong.items(), 2):
            self.assertIn(f"cansync: {self.path('batch')}:{number}:{column}: ", told, line)
        self.assertIn(f"{len(wrong)} lines are wrong; nothing was sent", told)
        self.assertEqual(self.one("read", 0, WORD)["value"], 1)

    def test_it_stops_or_goes_on_at_an_error(self):
        text = f"write 0 {WORD} 5\nread 9 1\nread nobody 1\nwrite 0 {WORD} 6\n"
        stopped = self.batch(text, code=3)
        self.assertIn(f"cansync: {self.path('batch')}:2: slave 9", stopped.stderr)
        self.assertEqual(self.one("read", 0, WORD)["value"], 5)
        went_on = self.batch(text, "--continue", code=3)
        self.assertIn(f"cansync: {self.path('batch')}:3: SLAVE: slave 'nobody'", went_on.stderr)
        self.assertEqual(self.one("read", 0, WORD)["value"], 6)

    def test_json_tells_how_each_line_ended(self):
        path = self.file("batch", f"read 1 {WORD}\nread 9 1\nmode run --force\n")
        found = self.json("batch", path, "--continue", code=3)
        ends = [(one["line"], one["verb"], one["exit_code"]) for one in found if "exit_code" in one]
        self.assertEqual(ends[:2], [(1, "read", 0), (2, "read", 3)])
        self.assertEqual([one.get("result") for one in found[:4]], ["done", None, "refused", None])
        self.assertIn("slave 9: not configured", found[3]["reason"])

    def test_standard_input_line_by_line(self):
        process = self.gateway.start("batch", "-", "--json", "--continue", stdin=-1)

        def command(line):
            process.stdin.write(line.encode() + b"\n")
            process.stdin.flush()
            found = [process.next_object()]
            while "exit_code" not in found[-1]:
                found.append(process.next_object())
            return found

        self.assertEqual(command(f"write 2 {DOUBLEWORD} 70000")[0]["value"], 70000)
        self.assertEqual(command(f"read 2 {DOUBLEWORD}")[0]["value"], 70000)
        self.assertEqual(command("read 2 'x")[-1]["exit_code"], 2)
        self.assertEqual(command(f"download 2 {DATA} -")[-1]["exit_code"], 2)
        self.assertEqual(command("watch 0 --count 2 --interval 1")[-1]["exit_code"], 0)
        process.stdin.close()
        self.assertEqual(process.wait(LONG), 2)
        process.stdout.close()
        process.stderr.close()

    def test_ctrl_c_ends_line_and_batch(self):
        running = Running(self.gateway, "batch", self.file("batch", f"watch 0 --json\nwrite 0 {WORD} 77\n"))
        running.process.next_object()
        self.assertEqual(running.end(signal.SIGINT)[0], 7)
        self.assertNotEqual(self.one("read", 0, WORD)["value"], 77)

    def test_a_file_that_is_missing(self):
        self.assertIn("No such file", self.fails("batch", self.path("missing"), code=1))


if __name__ == "__main__":
    unittest.main(verbosity=2)
