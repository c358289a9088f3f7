"""Every class with tests in tests/end_to_end is run: its CMakeLists.txt names it as a group, or runs the whole file.

Usage: groups_check.py SOURCE | --self-test
"""
import ast
import pathlib
import re
import sys


def groups_run(cmake):
    """Groups of each file that are run, by its name without _test.py; "" stands for all."""
    found = {}
    for text in re.findall(r"cansync_end_to_end_groups\(([^)]*)\)", cmake):
        _, file, *groups = text.split()
        found.setdefault(file, set()).update(groups)
    for file, group in re.findall(r'cansync_end_to_end\(\S+ (\S+) (""|\w+)', cmake):
        found.setdefault(file, set()).add(group.strip('"'))
    return found


def classes_with_tests(source):
    """Each class that has tests of its own, with those of the file that inherit them."""
    classes = [node for node in ast.parse(source).body if isinstance(node, ast.ClassDef)]
    for node in classes:
        if any(isinstance(part, ast.FunctionDef) and part.name.startswith("test_") for part in node.body):
            heirs = {one.name for one in classes if any(isinstance(base, ast.Name) and base.id == node.name for base in one.bases)}
            yield node.name, {node.name, *heirs}


def never_run(cmake, sources):
    run = groups_run(cmake)
    return [f"{file}_test.py: {name}" for file, source in sorted(sources.items()) for name, names in classes_with_tests(source)
            if not {"", *names} & run.get(file, set())]


def main():
    if sys.argv[1:] == ["--self-test"]:
        source = "class Base:\n    def test_1(self): pass\nclass A(Base): pass\nclass B:\n    def test_2(self): pass\nclass Other: pass\n"
        cmake = 'cansync_end_to_end_groups(x one A)\ncansync_end_to_end(two two "")\n'
        assert never_run(cmake, {"one": source, "two": source, "three": source}) == [
            "one_test.py: B", "three_test.py: Base", "three_test.py: B"]
        return
    folder = pathlib.Path(sys.argv[1]) / "tests/end_to_end"
    sources = {path.name.removesuffix("_test.py"): path.read_text(encoding="utf-8") for path in folder.glob("*_test.py")}
    missing = never_run((folder / "CMakeLists.txt").read_text(encoding="utf-8"), sources)
    if missing:
        sys.exit("never run; name it in tests/end_to_end/CMakeLists.txt:\n" + "\n".join(missing))


main()
