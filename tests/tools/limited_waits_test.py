"""No test waits without a limit for a process, a thread or a command: what hangs must be told, not be waited for."""

import ast
import pathlib
import unittest

FOLDERS = ("kernel", "end_to_end", "packages", "pictures")
TESTS = pathlib.Path(__file__).resolve().parent.parent
# Of processes and threads; `join` of texts has an argument.
WAITS = {"wait", "communicate", "join"}
COMMANDS = {"run", "call", "check_call", "check_output"}


def unlimited(source):
    """The lines of a Python source that wait without a limit."""
    found = []
    for node in ast.walk(ast.parse(source)):
        if not isinstance(node, ast.Call) or not isinstance(node.func, ast.Attribute):
            continue
        options = {keyword.arg for keyword in node.keywords}
        waits = node.func.attr in WAITS and not node.args and not options
        owner = node.func.value
        command = (node.func.attr in COMMANDS and isinstance(owner, ast.Name) and owner.id == "subprocess"
                   and not options & {"timeout", None})
        if waits or command:
            found.append(node.lineno)
        # A bound method as a clean-up is called without a limit, too.
        if node.func.attr in ("addCleanup", "addClassCleanup"):
            found += [node.lineno for argument in node.args if isinstance(argument, ast.Attribute)
                      and argument.attr in WAITS and len(node.args) == 1 and not options]
    return found


class LimitedWaits(unittest.TestCase):
    def test_what_has_no_limit_is_found(self):
        for line in ("process.wait()", "process.communicate()", "thread.join()", "subprocess.run(['ip'], check=True)",
                     "self.addCleanup(simulator.wait)", "cls.addClassCleanup(cls.drives.wait)"):
            self.assertEqual(unlimited(line), [1], line)
        for line in ("process.wait(LONG)", "process.communicate(timeout=LONG)", "', '.join(names)", "run('ip')",
                     "subprocess.run(['ip'], check=True, timeout=LONG)", "subprocess.run(['ip'], **options)",
                     "self.addCleanup(end, simulator)", "self.addCleanup(simulator.wait, LONG)"):
            self.assertEqual(unlimited(line), [], line)

    def test_every_wait_has_a_limit(self):
        found = [f"{path.relative_to(TESTS)}:{line}" for folder in FOLDERS for path in sorted((TESTS / folder).rglob("*.py"))
                 for line in unlimited(path.read_text(encoding="utf-8"))]
        self.assertEqual(found, [], "these wait without a limit")


if __name__ == "__main__":
    unittest.main()
