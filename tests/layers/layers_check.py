#!/usr/bin/env python3
"""Holds the rooms of lib/, daemon/ and tools/ apart.

  layers_check.py ROOT         exit 1 and one line per violation, when there is any in ROOT
  layers_check.py --self-test  plants each kind of violation in a made-up tree and expects it to be found

Each room may include its own headers and those of the rooms its line in ROOMS names. A room names only rooms above it,
so there are no circles. A folder that has no line is a violation: whoever makes a room says what it may use; and so is
a line that allows what no file needs.
The core of each protocol is sans-IO besides: it includes only what is listed here, and names no clock.
lib/client/include is installed and included as <cansync/...>; what lies in lib/client/src is the library's own.
"""
import os
import re
import sys

from sources import PROTOCOL_LIST, load, load_list, protocols_in

# room: what it may use. `idl` is the generated header of the data model.
ROOMS = """
idl:
lib/system:
lib/text:                   lib/system
lib/config:                 lib/text
lib/profile:                lib/text lib/config
lib/can:                    lib/system
lib/dbc:                    lib/text lib/can
lib/signals:                lib/text lib/config lib/profile lib/dbc
lib/cansync:                lib/can
lib/layer2:                 lib/can
lib/j1939:                  lib/can
lib/rt:                     lib/system lib/can
lib/sync:                   lib/system lib/can lib/rt
lib/sim:                    lib/system lib/config lib/can lib/sync
lib/daemon_config:          lib/config lib/profile lib/can lib/sync
lib/dds:                    idl lib/system lib/text
lib/cansync/dds:            idl lib/text lib/cansync lib/dds
lib/cansync/sim:            lib/can lib/cansync lib/sim lib/sync
lib/cansync/config:         lib/text lib/config lib/profile lib/can lib/cansync lib/cansync/sim lib/daemon_config
lib/cansync_slave:          lib/cansync
lib/cansync_slave/config:   lib/config lib/profile lib/cansync lib/daemon_config
lib/cansync_cluster/config: lib/config lib/cansync lib/daemon_config lib/cansync/config lib/cansync_slave/config
lib/cansync_slave/dds:      idl lib/cansync lib/cansync_slave lib/dds
lib/cansync_slave/client:   idl lib/dds lib/cansync_slave/dds
lib/layer2/dds:             idl lib/text lib/can lib/layer2 lib/dds
lib/layer2/config:          lib/config lib/can lib/layer2 lib/daemon_config
lib/layer2/sim:             lib/can lib/sim
lib/layer2/client:          idl lib/can lib/dds lib/layer2/dds
lib/j1939/dds:              idl lib/text lib/j1939 lib/dds
lib/j1939/config:           lib/config lib/can lib/j1939 lib/daemon_config
lib/j1939/sim:              lib/can lib/j1939 lib/sim
lib/j1939/client:           idl lib/can lib/dbc lib/dds lib/j1939 lib/j1939/dds
lib/client:                 idl lib/text lib/profile lib/can lib/dbc lib/signals lib/layer2 lib/j1939 lib/dds lib/cansync/dds lib/cansync_slave/client lib/layer2/dds lib/layer2/client lib/j1939/client

daemon/service:             lib/system lib/text lib/config
daemon/bus:                 lib/can lib/sync lib/sim lib/daemon_config
daemon/loop:                lib/system lib/can lib/rt lib/sync lib/daemon_config daemon/bus
daemon/desk:                idl lib/text lib/rt lib/dds daemon/service daemon/loop
daemon/recorder:            lib/text lib/can lib/rt lib/daemon_config daemon/service daemon/loop daemon/desk
daemon/segment:             lib/text lib/config lib/can lib/rt lib/sync lib/sim lib/dds lib/daemon_config daemon/service daemon/loop daemon/desk
                            daemon/bus daemon/recorder
daemon/status:              idl lib/text lib/can lib/sync lib/rt lib/dds lib/daemon_config daemon/service daemon/loop daemon/bus daemon/desk
daemon/gateway:             lib/can lib/dds daemon/service daemon/bus daemon/desk daemon/status
daemon/cansync:             lib/can lib/cansync lib/rt lib/sync daemon/loop
daemon/cansync/bus:         lib/cansync lib/cansync/sim daemon/bus lib/cansync/config
daemon/cansync/realtime:    lib/can lib/cansync lib/rt lib/sync daemon/loop daemon/bus daemon/cansync
                            lib/cansync/config
daemon/cansync/texts:       idl lib/text lib/daemon_config lib/profile lib/can lib/cansync lib/dds lib/cansync/dds daemon/service daemon/loop
                            daemon/desk daemon/status daemon/cansync lib/cansync/config
daemon/cansync/requests:    idl lib/text lib/cansync lib/cansync/dds daemon/desk daemon/cansync lib/cansync/config
                            daemon/cansync/texts
daemon/cansync/status:      idl lib/text lib/profile lib/can lib/cansync lib/dds lib/cansync/dds daemon/cansync
                            daemon/service lib/cansync/config daemon/cansync/texts daemon/desk daemon/status
daemon/cansync/gateway:     idl lib/text lib/cansync lib/dds lib/cansync/dds daemon/cansync daemon/service
                            lib/cansync/config daemon/cansync/texts daemon/cansync/requests daemon/desk
                            daemon/gateway daemon/cansync/status
daemon/cansync/segment:     lib/text lib/cansync lib/dds lib/cansync/sim daemon/service daemon/bus
                            daemon/loop daemon/segment daemon/recorder daemon/cansync lib/cansync/config
                            daemon/cansync/bus daemon/cansync/realtime daemon/cansync/gateway
daemon/cansync_slave:       lib/can lib/cansync lib/cansync_slave lib/rt daemon/loop
daemon/cansync_slave/realtime: lib/can lib/cansync lib/sync daemon/loop daemon/bus daemon/cansync_slave
                            lib/cansync_slave/config
daemon/cansync_slave/gateway: idl lib/text lib/can lib/cansync lib/sync lib/dds lib/cansync_slave/dds daemon/service daemon/desk daemon/gateway daemon/status
                            daemon/cansync_slave lib/cansync_slave/config
daemon/cansync_slave/segment: lib/can lib/cansync lib/cansync/sim
                            daemon/bus daemon/segment daemon/cansync_slave lib/cansync_slave/config
                            daemon/cansync_slave/realtime daemon/cansync_slave/gateway
daemon/cansync_cluster/segment: lib/text lib/config lib/cansync lib/dds lib/cansync/sim daemon/service daemon/loop daemon/bus
                            daemon/segment daemon/recorder daemon/cansync lib/cansync/config daemon/cansync/bus
                            daemon/cansync/realtime daemon/cansync/gateway daemon/cansync_slave
                            daemon/cansync_slave/gateway daemon/cansync_slave/realtime daemon/cansync_slave/segment
                            lib/cansync_cluster/config
daemon/layer2:              lib/can lib/layer2 lib/rt
daemon/layer2/realtime:     lib/can lib/layer2 daemon/loop daemon/bus daemon/layer2
daemon/layer2/gateway:      idl lib/text lib/can lib/layer2 lib/dds lib/layer2/dds daemon/service daemon/desk
                            daemon/gateway daemon/status
                            daemon/layer2 lib/layer2/config
daemon/layer2/segment:      lib/text lib/can lib/sim lib/layer2/sim
                            daemon/bus daemon/segment daemon/layer2 lib/layer2/config
                            daemon/layer2/realtime daemon/layer2/gateway
daemon/j1939:               lib/can lib/j1939 lib/rt
daemon/j1939/realtime:      lib/can lib/j1939 daemon/loop daemon/bus daemon/j1939
daemon/j1939/gateway:       idl lib/text lib/j1939 lib/dds lib/j1939/dds daemon/service daemon/desk
                            daemon/gateway daemon/status
                            daemon/j1939 lib/j1939/config
daemon/j1939/segment:       lib/text lib/can lib/sim lib/j1939/sim
                            daemon/bus daemon/segment daemon/j1939 lib/j1939/config
                            daemon/j1939/realtime daemon/j1939/gateway
daemon:                     lib/text lib/config lib/can lib/rt daemon/service lib/daemon_config daemon/segment

tools/cli/text:             lib/text
tools/cli/base:             lib/system lib/text lib/dds lib/client tools/cli/text
tools/cli/connect:          lib/dds tools/cli/text tools/cli/base
tools/cli/dbc:              lib/text lib/dbc lib/signals tools/cli/text tools/cli/base
tools/cli/cansync:          lib/text lib/profile lib/can lib/cansync lib/cansync/dds lib/dds lib/client tools/cli/text tools/cli/base tools/cli/connect
tools/cli/cansync/parameter: lib/text lib/profile tools/cli/text tools/cli/base tools/cli/cansync
tools/cli/look:             lib/text lib/profile lib/client tools/cli/text tools/cli/base tools/cli/cansync
tools/cli/watch:            lib/system lib/text lib/profile lib/client tools/cli/text tools/cli/base tools/cli/cansync
tools/cli/record:           lib/system lib/text lib/client tools/cli/text tools/cli/base tools/cli/watch
tools/cli/doctor:           lib/text lib/config lib/can lib/rt lib/dds lib/client tools/cli/text tools/cli/base tools/cli/cansync
tools/cli/trace:            lib/system lib/text lib/can lib/cansync lib/cansync/config tools/cli/text tools/cli/base tools/cli/cansync
tools/cli/learn:            lib/system lib/text lib/profile lib/cansync lib/cansync/config tools/cli/text
                            tools/cli/base tools/cli/cansync tools/cli/trace
tools/cli/scan:             lib/text lib/system lib/profile lib/can lib/cansync tools/cli/text tools/cli/base
                            tools/cli/cansync tools/cli/trace tools/cli/learn
tools/cli/setup:            lib/text lib/config lib/cansync/config tools/cli/base tools/cli/cansync tools/cli/learn
tools/cli/jobs:             lib/dds tools/cli/text tools/cli/base tools/cli/connect
tools/cli/cansync_slave:    lib/text lib/config lib/profile lib/cansync lib/dds lib/cansync_slave/config lib/cansync_slave/client tools/cli/text tools/cli/base tools/cli/connect
tools/cli/cansync_cluster:  tools/cli/base
tools/cli/layer2:           lib/text lib/can lib/dbc lib/layer2 lib/layer2/dds lib/layer2/client tools/cli/text tools/cli/base tools/cli/dbc tools/cli/trace tools/cli/connect
tools/cli/j1939:            idl lib/text lib/dbc lib/j1939 lib/dds lib/j1939/dds lib/j1939/client tools/cli/text tools/cli/base tools/cli/dbc tools/cli/trace tools/cli/connect
tools/cli/app:              lib/text lib/client tools/cli/text tools/cli/base tools/cli/cansync tools/cli/look
                            tools/cli/watch tools/cli/record tools/cli/doctor tools/cli/trace tools/cli/learn
                            tools/cli/scan tools/cli/setup tools/cli/jobs
tools/simulator:            lib/system lib/text lib/config lib/can lib/cansync lib/sync lib/sim lib/cansync/sim lib/cansync/config
                           
"""
PLACES = ("lib/", "daemon/", "tools/cli/", "tools/simulator/")

# The protocols' cores. Standard headers they may use: nothing that reaches a file, a thread or the system.
CORES = ("lib/cansync", "lib/layer2", "lib/j1939")
CORE_HEADERS = set("""algorithm array bit bitset chrono compare concepts cstddef cstdint cstring deque functional
initializer_list iterator limits memory new numeric optional ranges span string string_view tuple type_traits utility
variant vector""".split())
CORE_FRAMES = ("can/bounded_list.h", "can/frame.h", "can/frame_length.h", "can/job_ending.h", "can/obstacle.h")
CORE_WORDS = re.compile(r"steady_clock|system_clock|high_resolution_clock|utc_clock|clock_gettime|gettimeofday|std::time\b|"
                        r"this_thread|fopen|printf|getenv|std::(cout|cerr|clog)")
CANSYNC_WORDS = {"lib/config": re.compile("cansync|slave|daemon"),
                 "lib/can": re.compile("cansync"),
                 "lib/rt": re.compile("cansync/|cansync::|namespace cansync"),
                 "lib/sim": re.compile("cansync/|cansync::|namespace cansync"),
                 "lib/sync": re.compile("cansync/|cansync::|namespace cansync"),
                 "lib/dds": re.compile("cansync/|cansync::|cansync_|cansync[.]h|namespace cansync")}
# Rooms of the daemon that every protocol has: its words, but not the paths of this product.
CANSYNC_WORDS |= {f"daemon/{room}": re.compile(r'"cansync/|cansync::|\bcansync_[A-Z]|"cansync[.]h"|namespace cansync\b')
                  for room in "service loop bus segment desk status gateway".split()}
CANSYNC_WORDS["lib/daemon_config"] = CANSYNC_WORDS["daemon/bus"]
# The headers made of the data model, one for each protocol that has topics of its own.
MODEL_HEADERS = {f"{model}.h" for model in
                 ["gateway", "overview", *protocols_in(load_list(os.path.join(os.path.dirname(__file__), "..", "..")))]}
# What a protocol's library has beside its core: rooms of their own.
PROTOCOL_ROOMS = re.compile(r"lib/\w+/(config|dds|sim|client)\b")
# How an identifier is put together stands in one file.
IDENTIFIER_BITS = re.compile(r"\b0x780u?\b|\b\w*(id|identifier)\b[^;]*&\s*~?0x7Fu?\b|uint32_t[^;]*=\s*0x7Fu?;")
# What is installed of the client library, and the one header that shows the generated types.
INSTALLED = "lib/client/include/cansync/"
DATA_MODEL_FILE = INSTALLED + "topics.h"
IDENTIFIER_FILE = "lib/cansync/telegram/telegram.h"
# So does what stands where in a reply: nobody else takes its bytes or a number out of bytes.
REPLY_BYTES = re.compile(r"(\.|->)payload(_size)?\b|\b(load|store)_(double)?word\b")
REPLY_FILE = "lib/cansync/telegram/reply_payload.h"
REPLY_FILES = {REPLY_FILE, *(f"lib/cansync/telegram/{name}" for name in ("telegram.h", "telegram.cpp", "reply_payload.cpp"))}
# Likewise of what nodes of J1939 say to each other.
MESSAGE_BYTES = re.compile(r"\bdata\[")
MESSAGE_FILE = "lib/j1939/codec.h"
MESSAGE_FILES = {"lib/j1939/codec.cpp", "lib/j1939/identifier.h"}
INCLUDE = re.compile(r'\s*#\s*include\s*(["<])([^">]+)')


def read_table(text):
    """{room: rooms it may use}; ValueError names a room that stands above one it uses, or one of tools that uses the daemon."""
    rooms = {}
    for line in re.sub(r"\n +", " ", text).splitlines():
        if not line:
            continue
        room, uses = line.split(":")
        for used in uses.split():
            if used not in rooms:
                raise ValueError(f"{room} uses {used}, which does not stand above it")
            if room.startswith("tools/") and used.startswith("daemon"):
                raise ValueError(f"{room} uses {used}: what both need belongs in lib")
        rooms[room] = set(uses.split())
    return rooms


def room_of(folder):
    """Of a folder; subfolders of a library belong to it, but for the rooms that a protocol's has."""
    if own := PROTOCOL_ROOMS.match(folder):
        return own[0]
    return "/".join(folder.split("/")[:2]) if folder.startswith("lib/") else folder


def libraries_of(rooms):
    return {room.split("/")[1] for room in rooms if room.startswith("lib/")}


def included_room(file, bracket, path, libraries):
    """The room an #include leads to; nothing for headers of others and of the file's own folder."""
    first = path.split("/")[0]
    if bracket == "<" and first == "dds":
        return "dds"
    if bracket == "<" and first == "cansync":
        return "lib/client"
    if path in MODEL_HEADERS or path == "ddsc/dds.h" or re.fullmatch(r"dds[a-z_]*\.h", path):
        return "idl"
    if "/" not in path:
        return None
    folder = os.path.dirname(path)
    if first in (".", ".."):
        return room_of(os.path.normpath(f"{os.path.dirname(file)}/{folder}"))
    if first in libraries:
        return room_of(f"lib/{folder}")
    if first in ("cli", "simulator"):
        return f"tools/{folder}"
    return folder if first in ("daemon", "tools") else None


def used_rooms(files, rooms):
    """{room: the rooms its files include}."""
    libraries = libraries_of(rooms)
    used = {room: set() for room in rooms}
    for file, text in files.items():
        room = room_of(os.path.dirname(file))
        for include in filter(None, map(INCLUDE.match, text.split("\n"))):
            used.setdefault(room, set()).add(included_room(file, include[1], include[2], libraries))
    return used


def unneeded(files, rooms):
    """What the table has too much."""
    used = used_rooms(files, rooms)
    found = [f"{room}/ has a line in the table of rooms and no sources" for room in rooms
             if room != "idl" and not any(room_of(os.path.dirname(file)) == room for file in files)]
    return found + [f"the table allows {other} to {room}, which does not include it: take it out"
                    for room in rooms for other in sorted(rooms[room] - used[room])]


def may_use_dds(room, uses):
    return any(re.fullmatch(r"lib/(\w+/)?dds", other) for other in uses | {room})


def installed_may_include(files, file, bracket, path, there):
    if there == "idl":
        return file == DATA_MODEL_FILE
    if bracket == "<":
        return "/" not in path
    beside = os.path.normpath(f"{os.path.dirname(file)}/{path}")
    return beside.startswith(INSTALLED) and beside in files


def check(files, rooms):
    """Violations in {path: text}, as "path:line: text   <- rule"."""
    found = []
    libraries = libraries_of(rooms)
    for file, text in sorted(files.items()):
        room = room_of(os.path.dirname(file))
        if room not in rooms:
            found.append(f"{file}:1:   <- {room}/ stands in no line of the table of rooms")
            continue
        uses = rooms[room]
        for number, line in enumerate(text.split("\n"), 1):
            def report(rule):
                found.append(f"{file}:{number}: {line.strip()}   <- {rule}")

            if room in CANSYNC_WORDS and CANSYNC_WORDS[room].search(line):
                report(f"{room} may not know CANsync")
            if IDENTIFIER_BITS.search(line) and file != IDENTIFIER_FILE:
                report(f"channel and number of an identifier: channel_of and participant_of of {IDENTIFIER_FILE}")
            if REPLY_BYTES.search(line) and file not in REPLY_FILES:
                report(f"what a reply holds: the views of {REPLY_FILE}")
            if room == "lib/j1939" and MESSAGE_BYTES.search(line) and file not in MESSAGE_FILES:
                report(f"what a message holds: {MESSAGE_FILE}")
            if room in CORES and CORE_WORDS.search(line):
                report("the sans-IO core reads no clock and no file")
            if room.startswith("lib/") and not may_use_dds(room, uses) and re.search(r"\bdds_[a-z]+", line):
                report(f"{room} may not use DDS")
            include = INCLUDE.match(line)
            if not include:
                continue
            bracket, path = include[1], include[2]
            if path.startswith("toml++") and room != "lib/config":
                report("lib/config is the one reader of TOML")
            there = included_room(file, bracket, path, libraries)
            if path.startswith("client/src/") and room != "lib/client":
                report("lib/client/src is the library's own: include <cansync/...>")
            if file.startswith(INSTALLED) and not installed_may_include(files, file, bracket, path, there):
                report("an installed header includes its own kind and the standard library; topics.h the data model")
            if room in CORES:
                protocol = room.split("/")[1]
                own = bracket == '"' and (path in CORE_FRAMES or re.fullmatch(protocol + r"/([a-z_]+/)?[a-z_]+\.h", path)
                                         and there == room)
                if not own and not (bracket == "<" and path in CORE_HEADERS):
                    report("not on the list of headers for the sans-IO core")
            elif there == "dds":
                if not may_use_dds(room, uses):
                    report(f"{room} may not use DDS")
            elif room == "daemon" and there and there.count("/") == 2:
                # Rooms of the daemon within a room are a protocol's, and nothing outside includes them.
                report(f"{PROTOCOL_LIST} is the only list of protocols")
            elif there not in uses | {room, None}:
                report(f"{room} may not include {there}")
    return found


# --- self-test

CLEAN = {
    "lib/cansync/clean.cpp": '#include <array>\n#include "can/frame.h"\n#include "cansync/telegram/numbers.h"\n',
    "lib/layer2/clean.cpp": '#include <array>\n#include "can/frame.h"\n#include "layer2/station.h"\n',
    "lib/sim/clean.h": '#include "can/bus.h"\n',
    "lib/dds/clean.cpp": '#include <dds/dds.h>\n#include "gateway.h"\n',
    "lib/cansync/dds/clean.cpp": '#include "cansync/channel/jobs.h"\n#include "cansync.h"\n#include "dds/topic.h"\n',
    "lib/client/src/c_face/clean.c": '#include "../clean.h"\n#include "client/src/link.h"\n#include <cansync/client.h>\n',
    INSTALLED + "clean.h": '#include <vector>\n',
    INSTALLED + "blocks/clean.h": '#include "../clean.h"\n',
    DATA_MODEL_FILE: '#include "cansync.h"\n#include "clean.h"\n',
    "daemon/bus/clean.h": '#include <vector>\n#include "daemon/bus/bus_plan.h"\n#include "clean_too.h"\n',
    "tools/cli/text/clean.cpp": '#include "cli/text/table.h"\n// dds_interface\n',
}

PLANTED = [
    *[(f"{core}/planted.cpp", f"#include <{header}>") for core in CORES for header in
      "thread mutex fstream iostream atomic sys/socket.h unistd.h time.h ctime random fmt/format.h".split()],
    ("lib/cansync/planted.h", '# include "can/bus.h"'),
    ("lib/layer2/planted.h", '# include "can/bus.h"'),
    ("lib/layer2/planted.h", '#include "cansync/settings/mode.h"'),
    ("lib/layer2/planted.cpp", "auto now = std::chrono::steady_clock::now();"),
    ("lib/cansync/planted.h", '#include "planted_too.h"'),
    ("lib/cansync/planted.cpp", "auto now = std::chrono::steady_clock::now();"),
    ("lib/cansync/planted.cpp", "using Clock = std::chrono::system_clock;"),
    ("lib/cansync/planted.cpp", "const auto channel = frame.id & 0x780;"),
    ("daemon/bus/planted.cpp", "const unsigned slave = frame.id & 0x7F;"),
    ("tools/simulator/planted.cpp", "const auto channel = identifier & ~0x7Fu;"),
    ("lib/sim/planted.cpp", "constexpr std::uint32_t kNumberBits = 0x7F;"),
    ("lib/cansync/planted.cpp", "if (reply.payload_size == 6) return;"),
    ("lib/cansync/planted.cpp", "const auto value = load_word(bytes);"),
    ("lib/cansync/sim/planted.cpp", "answer->payload = {};"),
    ("lib/j1939/planted.cpp", "const auto control = frame.data[0];"),
    ("daemon/cansync/realtime/planted.cpp", "const auto code = cansync::load_doubleword(data);"),
    ("tools/cli/cansync/planted.cpp", "const std::uint8_t low = reply.payload[0];"),
    ("tools/cli/trace/planted.cpp", "store_word(bytes, 7);"),
    ("lib/can/planted.cpp", "int f(cansync::SlaveNumber);"),
    ("lib/profile/planted.cpp", "#include <toml++/toml.h>"),
    ("lib/daemon_config/planted.cpp", "#include <toml++/toml.h>"),
    ("lib/daemon_config/planted.h", "namespace cansync {}"),
    ("tools/cli/setup/planted.cpp", '#include "daemon/bus/bus_plan.h"'),
    ("lib/config/planted.h", "int slave = -1;"),
    ("lib/config/planted.cpp", "using cansyncd::Config;"),
    ("lib/config/planted.cpp", "// as the daemon has it"),
    ("lib/rt/planted.h", "void f(const cansync::Telegram&);"),
    ("daemon/bus/planted.h", "void f(const cansync::Telegram&);"),
    ("daemon/segment/planted.cpp", "cansync_MasterStatus sample;"),
    ("daemon/planted.cpp", '#include "daemon/cansync/segment/master_protocol.h"'),
    ("lib/sim/planted.h", "void f(const cansync::Telegram&);"),
    ("lib/rt/planted.cpp", "auto x = dds_create_participant(0, nullptr, nullptr);"),
    ("lib/dds/planted.h", "cansync::Telegram f();"),
    ("lib/dds/planted.h", '#include "cansync.h"'),
    ("lib/cansync/planted.cpp", '#include "cansync/dds/topics.h"'),
    ("lib/sim/planted.cpp", "#include <dds/dds.h>"),
    ("lib/sync/planted.cpp", "#include <dds/dds.h>"),
    ("lib/rt/planted.cpp", '#include "../sync/phase_lock.h"'),
    ("daemon/cansync/realtime/planted.cpp", "#include <dds/dds.h>"),
    ("daemon/planted/planted.h", "#include <vector>"),
    ("daemon/bus/planted.h", '#include "daemon/planted/planted_too.h"'),
    ("daemon/desk/planted.cpp", '#include "cli/base/session.h"'),
    ("daemon/desk/planted.cpp", '#include "daemon/cansync/exchange.h"'),
    *[("daemon/loop/planted.h", f'#include "{header}"') for header in sorted(MODEL_HEADERS)],
    ("daemon/desk/planted.h", '#include "cansync.h"'),
    ("daemon/desk/planted.h", "std::optional<cansync_Command> newest;"),
    ("tools/cli/planted.cpp", "#include <vector>"),
    ("tools/cli/text/planted.cpp", "#include <dds/dds.h>"),
    ("tools/simulator/planted.cpp", '#include "tools/cli/base/session.h"'),
    ("tools/simulator/planted.cpp", "#include <cansync/client.h>"),
    ("tools/cli/base/planted.cpp", '#include "client/src/link.h"'),
    *[(INSTALLED + "planted.h", f"#include {header}") for header in
      ('"cansync.h"', '"gateway.h"', "<dds/dds.h>", '"dds/endpoint.h"', '"client/src/link.h"', '"../../src/link.h"')],
]


def header_in(room):
    if room == "idl":
        return "cansync.h"
    for before, after in (("lib/", ""), ("tools/", "")):
        if room.startswith(before):
            room = after + room[len(before):]
    return f"{room}/planted_too.h"


def self_test(rooms):
    wrong = [f"a clean tree is refused: {line}" for line in check(CLEAN, rooms)]
    planted = list(PLANTED)
    # Every arrow that the table does not have.
    for room, uses in rooms.items():
        planted += [(f"{room}/planted.h", f'#include "{header_in(other)}"') for other in rooms
                    if room != "idl" and other not in uses | {room}]
    for path, line in planted:
        found = check(CLEAN | {path: f"#pragma once\n{line}\n"}, rooms)
        if not found or any(path not in text for text in found):
            wrong.append(f"not found: {path}: {line}")
    for table in ("a: b\nb: a", "a: a", "a:\nb: c\nc: a", "daemon/a:\ntools/b: daemon/a"):
        try:
            read_table(table)
            wrong.append(f"a circle, or an arrow from tools to the daemon, passes: {table!r}")
        except ValueError:
            pass
    few = read_table("idl:\nlib/dds: idl\ndaemon/planted:")
    if [line.split()[0] for line in unneeded(CLEAN, few)] != ["daemon/planted/"]:
        wrong.append("a room without sources passes, or more is found")
    if not unneeded({"lib/dds/clean.cpp": ""}, read_table("idl:\nlib/dds: idl")):
        wrong.append("what no file needs passes")
    print("\n".join(wrong) if wrong else f"self-test: each of {len(planted)} planted violations was found")
    return not wrong


def main():
    if len(sys.argv) != 2:
        sys.exit(f"usage: {sys.argv[0]} ROOT | --self-test")
    rooms = read_table(ROOMS)
    if sys.argv[1] == "--self-test":
        sys.exit(0 if self_test(rooms) else 1)
    files = load(sys.argv[1], PLACES)
    if not files:
        sys.exit(f"no sources in {sys.argv[1]}")
    found = check(files, rooms) + unneeded(files, rooms)
    if found:
        sys.exit("\n".join(found))
    print(f"{len(rooms)} rooms are apart, {len(files)} files")


main()
