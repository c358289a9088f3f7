"""The Python package as such: what is generated, its types, its help."""

import dataclasses
import enum
import inspect
import pathlib
import pydoc
import subprocess
import sys
import tempfile
import unittest

import cansync
from cansync import _native, topics

FOLDER = pathlib.Path(cansync.__file__).parent


class Package(unittest.TestCase):
    def test_every_member_of_every_topic_is_there(self):
        self.assertEqual(len(topics.NUMBERS), len(_native.ffi.typeof("enum cansync_topic").elements))
        for topic in topics.NUMBERS:
            members = [name for name, _ in _native.ffi.typeof(topic._struct).fields]
            self.assertEqual([field.name for field in dataclasses.fields(topic)], members, topic)

    def test_codes_are_those_of_the_c_face(self):
        numbers = _native.ffi.typeof("enum cansync_result").relements
        self.assertEqual({f"CANSYNC_{code.name}": code.value for code in cansync.Code}, numbers)
        for code in cansync.Code:
            if code:
                self.assertIs(cansync.errors.error_of(code, "no").code, code)
        causes = _native.ffi.typeof("gateway_RefusalCause").relements
        self.assertEqual({f"gateway_CAUSE_{cause.name}": cause.value for cause in cansync.Cause}, causes)
        ways = _native.ffi.typeof("enum cansync_retry").relements
        self.assertEqual({f"CANSYNC_RETRY_{way.name}": way.value for way in cansync.Retry}, ways)

    def test_types_are_whole(self):
        with tempfile.TemporaryDirectory() as cache:
            done = subprocess.run(["mypy", "--strict", f"--cache-dir={cache}", "--python-executable", sys.executable, FOLDER],
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=300, check=False)
        self.assertEqual(done.returncode, 0, done.stdout)

    def test_everything_public_has_its_docstring(self):
        for name in cansync.__all__:
            thing = getattr(cansync, name)
            if not callable(thing):
                continue
            self.assertTrue(thing.__doc__, name)
            if inspect.isclass(thing) and not issubclass(thing, (enum.Enum, Exception)):
                for method, function in inspect.getmembers(thing, inspect.isfunction):
                    self.assertTrue(method.startswith("_") or function.__doc__, f"{name}.{method}")

    def test_help_shows_what_can_be_done(self):
        text = pydoc.plain(pydoc.render_doc(cansync))
        for words in ("cansync.connect", "class Client", "read(self, slave", "class Refused", "not accepted, nothing was sent"):
            self.assertIn(words, text)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[1:]])
