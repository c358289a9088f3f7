#!/usr/bin/env python3
"""Names every file of lib/, daemon/ and tools/ outside the protocols' own folders that mentions a protocol.

  protocol_names_check.py ROOT         exit 1 and one line per file, when there is any in ROOT
  protocol_names_check.py --self-test  plants each kind of mention in a made-up tree and expects it to be found

The protocols are those of lib/protocols.def and of COMING. A protocol's own folders are lib/NAME, daemon/NAME and
tools/cli/NAME. Read are the sources in C and C++ alone (*.h, *.hpp, *.c, *.cpp): build files, scripts and configurations
may name a protocol. CANsync has the name of the product: of it count include paths, its namespace and its types of the data
model, not the programs cansync and cansyncd, their folders, the namespace of the command line, or the headers
<cansync/...> of the installed library.
What cannot be cured yet stands in EXCEPTIONS with its reason; an exception that is not needed any more is a violation.
"""
import re
import sys

from sources import PROTOCOL_LIST as LIST
from sources import load, load_list, protocols_in

PLACES = ("lib", "daemon", "tools")
COMING = ("canopen",)  # protocols that have no room yet
# Of the protocol that has the name of the product.
OF_CANSYNC = re.compile(r'"(?:daemon/|cli/|tools/cli/)?cansync/|["<]cansync\.h[">]|\bcansync::(?!cli\b)|'
                        r"\bnamespace cansync(?!::cli\b|d\b)\b|\bcansync_[A-Z]|\busing namespace cansync\b")

# File or folder: why it may mention a protocol.
EXCEPTIONS = {
    "lib/client/": "the one library that programs of others link: protocols have their connections and function blocks there",
    "tools/simulator/": "the program cansync-sim: simulated drives of CANsync and nothing else",
    "tools/examples/": "programs that show the library of CANsync",
    "tools/cli/base/session.h": "a session connects with the client library of CANsync and looks up names of its slaves",
    "tools/cli/base/session.cpp": "as session.h, whose functions it defines",
    "tools/cli/app/completion.cpp": "offers names of slaves and of parameters of their profiles",
    "tools/cli/look/wait.cpp": "waits for states of slaves, whose words stand in cansync/",
    "tools/cli/look/expect_value.cpp": "compares actual values and parameters of slaves, as wait.cpp waits for them",
    "tools/cli/learn/": "learns from a recording what a master of CANsync does; reads logs as trace does",
    "tools/cli/scan/": "finds the participants of a line of CANsync; listens as learn does",
    "tools/cli/setup/": "asks for the slaves of a configuration of a CANsync master",
    "tools/cli/trace/trace.cpp": "puts frames into words by the one protocol whose telegrams it knows",
    "tools/cli/trace/trace_interface.cpp": "as trace.cpp: receives the identifiers of CANsync",
    "tools/cli/doctor/doctor.cpp": "tells the faults of a line's slaves",
    "tools/cli/watch/watch_rows.h": "the rows of slaves have their faults in words",
    "tools/cli/watch/watched_parameters.h": "parameters of slaves have the names of their profiles",
    "tools/cli/watch/live_model.h": "the live view shows slaves and the timing of their telegrams",
}


def patterns(files):
    """{protocol: what mentions it}."""
    return {name: OF_CANSYNC if name == "cansync" else re.compile(name, re.IGNORECASE)
            for name in (*protocols_in(files[LIST]), *COMING)}


def is_own(path, protocols):
    """A file in a protocol's own folder."""
    parts = path.split("/")
    place = parts[2:] if parts[:2] == ["tools", "cli"] else parts[1:] if parts[0] in ("lib", "daemon") else []
    return len(place) > 1 and place[0] in protocols


def mentions(files):
    """{path: (line number, line, protocol)} of the first mention in each file that may have none."""
    found, known = {}, patterns(files)
    for path, text in sorted(files.items()):
        if is_own(path, known) or path == LIST:
            continue
        for number, line in enumerate(text.split("\n"), 1):
            name = next((name for name, pattern in known.items() if pattern.search(line)), None)
            if name:
                found[path] = (number, line.strip(), name)
                break
    return found


def covers(exception, path):
    return path == exception or (exception.endswith("/") and path.startswith(exception))


def check(files, exceptions):
    """Violations in {path: text}, one line each."""
    found = mentions(files)
    wrong = [f"{path}:{number}: {line}   <- mentions {name}; only its own folders and {LIST} may"
             for path, (number, line, name) in found.items()
             if not any(covers(exception, path) for exception in exceptions)]
    wrong += [f"{exception} mentions no protocol: take it out of EXCEPTIONS" for exception in exceptions
              if not any(covers(exception, path) for path in found)]
    return wrong + [f"{exception} has no reason in EXCEPTIONS" for exception, why in exceptions.items() if len(why) < 20]


# --- self-test

CLEAN = {
    "lib/cansync/master.h": '#include "cansync/mode.h"\nnamespace cansync {}',
    "lib/layer2/dds/convert.h": '#include "layer2.h"',
    "daemon/layer2/exchange.h": "namespace layer2 {}",
    "tools/cli/cansync/status.cpp": "cansync_MasterStatus status;",
    "lib/protocols.def": "PROTOCOL(cansync)\nPROTOCOL(cansync_slave)\nPROTOCOL(cansync_cluster)\nPROTOCOL(layer2)\n"
                         "PROTOCOL(j1939)\n",
    "daemon/main.cpp": 'print("cansyncd: no file");\nnamespace cansyncd {}\n// the program cansync',
    "tools/cli/base/session.cpp": "#include <cansync/client.h>\nnamespace cansync::cli {\nfolder = \"/etc/cansync/profiles\";\n}",
}
PLANTED = [
    ("daemon/desk/planted.h", '#include "cansync.h"'),
    ("daemon/desk/planted.h", '#include "cansync/numbers.h"'),
    ("daemon/loop/planted.h", '#include "daemon/cansync/exchange.h"'),
    ("tools/cli/look/planted.cpp", '#include "cli/cansync/status_lines.h"'),
    ("daemon/bus/planted.cpp", "cansync::SlaveNumber slave;"),
    ("lib/sim/planted.h", "namespace cansync {"),
    ("lib/can/planted.h", "using namespace cansync;"),
    ("daemon/service/planted.cpp", "cansync_MasterStatus status;"),
    ("daemon/planted.cpp", 'if (protocol == "layer2") start();'),
    ("daemon/protocols.cpp", '#include "daemon/layer2/segment/layer2_protocol.h"'),
    ("tools/cli/app/protocols.cpp", '#include "cli/cansync/verbs.h"'),
    ("daemon/segment/planted.cpp", "class Layer2Segment;"),
    ("lib/can/planted.cpp", "// as J1939 does"),
    ("tools/cli/base/planted.h", '#include "canopen/object.h"'),
    ("tools/simulator/planted.cpp", "cansync::MasterSettings settings;"),
    ("daemon/layer2.cpp", "void layer2();"),
]


def self_test():
    wrong = [f"a clean tree is refused: {line}" for line in check(CLEAN, {})]
    for path, line in PLANTED:
        found = check(CLEAN | {path: f"#pragma once\n{line}\n"}, {})
        if [text.split(":")[0] for text in found] != [path]:
            wrong.append(f"not found: {path}: {line}")
    another = CLEAN | {"daemon/desk/planted.h": "// as Newbus does", "daemon/newbus/exchange.h": "namespace newbus {}"}
    if check(another, {}):
        wrong.append("what is no protocol is one")
    found = check(another | {LIST: CLEAN[LIST] + "PROTOCOL(newbus)\n"}, {})
    if [text.split(":")[0] for text in found] != ["daemon/desk/planted.h"]:
        wrong.append("a new protocol of the list is not looked for, or has no folder of its own")
    planted = CLEAN | {"daemon/desk/planted.h": "cansync::SlaveNumber slave;"}
    reason = "it will be cured with the desk"
    if check(planted, {"daemon/desk/planted.h": reason}) or check(planted, {"daemon/desk/": reason}):
        wrong.append("an exception does not hold")
    if not check(CLEAN, {"daemon/desk/": reason}):
        wrong.append("an exception that is not needed passes")
    if not check(planted, {"daemon/desk/": ""}):
        wrong.append("an exception without a reason passes")
    print("\n".join(wrong) if wrong else f"self-test: each of {len(PLANTED)} planted mentions was found")
    return not wrong


def main():
    if len(sys.argv) != 2:
        sys.exit(f"usage: {sys.argv[0]} ROOT | --self-test")
    if sys.argv[1] == "--self-test":
        sys.exit(0 if self_test() else 1)
    files = load(sys.argv[1], PLACES)
    if not files:
        sys.exit(f"no sources in {sys.argv[1]}")
    files[LIST] = load_list(sys.argv[1])
    found = check(files, EXCEPTIONS)
    if found:
        sys.exit("\n".join(found))
    print(f"{len(files)} files, {len(mentions(files))} of them excepted; protocols: {', '.join(patterns(files))}")


main()
