"""Writes the C source of the extension module `cansync._native`, and `cansync/codes.py`, out of the installed C header.

    make_native.py CC INCLUDE_FOLDERS NATIVE_C CODES_PY        INCLUDE_FOLDERS: separated by ':'

What cffi is told is what the C preprocessor makes of <cansync/cansync_c.h> and of the generated structs of the data model;
nothing of it is written by hand, and the C compiler checks it against the same headers.
"""

import pathlib
import re
import subprocess
import sys

import cffi

SOURCE = "#include <cansync/cansync_c.h>\n#include <cansync/cansync_c_slave.h>\n#include \"gateway.h\"\n#include \"cansync.h\"\n"
FACE = "cansync_c*.h"  # the headers of the C face
OURS = (FACE, "cansync.h", "gateway.h")
# C's types of callbacks that Python implements: `on_sample` becomes a function of the module.
CALLBACKS = ("cansync_on_sample", "cansync_go_on")
ENUMS = {"cansync_result": ("Code", "CANSYNC_"), "cansync_cause": ("Cause", "CANSYNC_CAUSE_"),
         "cansync_retry": ("Retry", "CANSYNC_RETRY_"), "cansync_mode_command": ("Mode", "CANSYNC_MODE_"),
         "cansync_slave_event_kind": ("SlaveEventKind", "CANSYNC_SLAVE_"),
         "cansync_slave_fault": ("SlaveFault", "CANSYNC_SLAVE_FAULT_")}
HEAD = '"""Numbers of the C face, made of cansync_c.h."""\n\nimport enum\n'


def preprocessed(compiler, folders):
    """Declarations of our headers alone, without attributes."""
    command = [compiler, "-E", *(f"-I{folder}" for folder in folders), "-x", "c", "-"]
    text = subprocess.run(command, input=SOURCE, stdout=subprocess.PIPE, text=True, check=True).stdout
    kept, ours = [], False
    for line in text.splitlines():
        if marker := re.match(r'# \d+ "([^"]*)"', line):
            ours = any(pathlib.Path(marker[1]).match(name) for name in OURS)
        elif ours:
            kept.append(line)
    text = "\n".join(kept).replace('__attribute__((visibility("default")))', "")
    return re.sub(r"extern const dds_topic_descriptor_t \w+;", "", text)


def callbacks(declarations):
    """extern "Python" functions with the types that the header declares."""
    found = re.findall(r"typedef\s+(\w+)\s+\(\*(\w+)\)(\([^;]*\));", declarations)
    types = {name: f"{result} {name.replace('cansync_', 'python_')}{arguments};" for result, name, arguments in found}
    return 'extern "Python" {\n' + "\n".join(types[name] for name in CALLBACKS) + "\n}\n"


def codes(header):
    """Python enumerations of those of the header, with its comments."""
    parts = [HEAD]
    for name, (python, prefix) in ENUMS.items():
        comment, body = re.search(rf"/\*((?:(?!\*/).)*)\*/\nenum {name} {{(.*?)}};", header, re.DOTALL).groups()
        text = re.sub(r"\s*\n \* *", "\n    ", comment.strip())
        members = re.findall(rf"{prefix}(\w+)\s*=\s*(\d+),?[ \t]*(?:/\*(.*?)\*/)?", body, re.DOTALL)
        notes = [(member, " ".join(comment.replace("*", " ").split())) for member, _, comment in members]
        parts.append(f'\n\nclass {python}(enum.IntEnum):\n    """{text}\n\n'
                     + "".join(f"    {member}: {note}\n" for member, note in notes if note)
                     + '    """\n\n' + "".join(f"    {member} = {number}\n" for member, number, _ in members))
    return "".join(parts)


def main():
    compiler, folders, native, codes_py = sys.argv[1:]
    folders = folders.split(":")
    declarations = preprocessed(compiler, folders)
    builder = cffi.FFI()
    builder.cdef(declarations + callbacks(declarations))
    builder.set_source("cansync._native", SOURCE)
    builder.emit_c_code(native)
    headers = [path for folder in folders for path in sorted(pathlib.Path(folder, "cansync").glob(FACE))]
    face = "\n".join(path.read_text(encoding="utf-8") for path in headers)
    pathlib.Path(codes_py).write_text(codes(face), encoding="utf-8")


main()
