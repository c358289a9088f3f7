"""The dissector says of every frame what `cansync trace` says, which is the C++ decoder with its names.

Compared are the log with every telegram, every error code near those of the manuals, thousands of random frames, and
the trace of a simulated line. So no table of the dissector can drift from lib/cansync.
"""
import os
import random
import re

from captures import HERE, SOURCE, Folder, differences

FIELDS = ["cansync.channel", "cansync.slave", "cansync.text", "can.id"]


def is_cansync(identifier):
    return identifier == 0x010 or identifier >> 8 in (1, 3, 5)


def told_by_trace(folder, log):
    """Channel, slave, text of each frame that belongs to the dissector; None for the others."""
    out = []
    for frame in folder.traced(log):
        if frame["channel"] == "error" or (frame["channel"] != "SYNC" and not is_cansync(frame["identifier"])):
            out.append(None)
            continue
        slave = "" if frame["slave"] is None else str(frame["slave"])
        out.append(f"{frame['channel']}|{slave}|{frame['text']}")
    return out


def told_by_tshark(folder, capture):
    return ["|".join(row[:3]) if row[0] else None for row in folder.fields(capture, FIELDS)]


def compare(folder, log, at_least):
    """Returns the capture of the log."""
    capture = folder.capture(log)
    expected, got = told_by_trace(folder, log), told_by_tshark(folder, capture)
    assert len(expected) >= at_least, len(expected)
    assert got == expected, f"{log}:\n{differences([str(e) for e in expected], [str(g) for g in got])}"
    return capture


def every_code(path):
    lines = []
    for code in [*range(0x0000, 0x0200), *range(0xFF00, 0x10000)]:
        little = code.to_bytes(2, "little").hex()
        lines += [f"(1.000000) can0 583#2064{little}", f"(1.000000) can0 583#2064{little}0500",
                  f"(1.000000) can0 584#A00C{little}"]
    path.write_text("\n".join(lines) + "\n")
    return path


def random_frames(path):
    """Frames on every identifier around CANsync's, of every length and kind; the answers find commands before them."""
    dice = random.Random(20)
    lines = []
    for _ in range(6000):
        slave = dice.choice([0, 3, 31, 32, 127, dice.randrange(128)])
        identifier = dice.choice([0x010, 0x011, 0x080, 0x200 + slave, *[base + slave for base in (
            0x100, 0x180, 0x300, 0x380, 0x500, 0x500, 0x500, 0x580, 0x580, 0x580)]])
        data = bytearray(dice.choice([0, 1, 0x0F, 0x80, 0xFF, dice.randrange(256)]) for _ in range(dice.randrange(9)))
        if data and identifier >= 0x500 and dice.random() < 0.7:
            data[0] = dice.choice([0x71, 0x01, 0x41, 0x21, 0x90, 0xD0, 0xA0, 0xB0, 0xE0, 0xF0, 0x80, 0xC0])
        if len(data) > 1 and dice.random() < 0.7:
            data[1] = dice.choice([0, 6, 12])
        kind = dice.random()
        if kind < 0.02:
            frame = f"{identifier:03X}#R{dice.randrange(9)}"
        elif kind < 0.04:
            frame = f"{identifier:08X}#{data.hex()}"
        else:
            frame = f"{identifier:03X}#{data.hex()}"
        lines.append(f"(1.000000) can0 {frame}")
    path.write_text("\n".join(lines) + "\n")
    return path


def check_simulated_line(folder):
    """A line without faults: nothing is marked but the error that was asked for, and every answer finds its command."""
    log = folder.path / "line.log"
    told = folder.run(os.environ["LINE_CAPTURE"], HERE / "line.toml", log).decode().splitlines()
    rows = folder.fields(compare(folder, log, 3000), ["cansync.channel", "cansync.request_in", "cansync.response_in",
                                               "_ws.expert.message", "cansync.transfer.block", "cansync.kind",
                                               "cansync.transfer.offset"])
    answers = [row for row in rows if row[0] == "RC"]
    commands = [row for row in rows if row[0] == "CC" and row[5]]
    assert len(answers) > 100 and all(row[1] for row in answers), "an answer without its command"
    assert all(row[2] for row in commands[:-1]), "a command without its answer"
    marks = [row[3] for row in rows if row[3]]
    assert marks == ["parameter 4000: error 0xFFFB, no such parameter or element"], marks
    block = next(line.split()[1] for line in told if line.startswith("block "))
    assert [row[4] for row in rows if row[4]] == [block, block], "downloaded, then uploaded"


def check_slot_times():
    """Every row of kSlotTimes in lib/cansync/settings/timing.h."""
    header = (SOURCE / "lib/cansync/settings/timing.h").read_text().replace("'", "")
    rows = re.findall(r"\{BitRate::\w+,\s*(\d+),\s*((?:us\(\d+\),\s*)+)\d+\}", header)
    assert len(rows) == 4, rows
    lua = (SOURCE / "tools/wireshark/cansync/cansync_names.lua").read_text()
    for rate, times in rows:
        values = re.findall(r"\d+", times)
        names = ["interval", "RC", "WRC1", "RDC1", "WRC2", "RDC2", "CC", "timeout"]
        expected = ", ".join(f"{name} = {value}" for name, value in zip(names, values, strict=True))
        assert f"[{rate}] = {{ {expected} }}" in lua, f"{rate}: {expected}"


def check_unexpected():
    """The names of answers that fit nothing, which `cansync trace` does not use."""
    source = (SOURCE / "lib/cansync/names.cpp").read_text()
    lua = (SOURCE / "tools/wireshark/cansync/cansync_names.lua").read_text()
    for key in ("wrong_answer", "duplicate"):
        name = re.search(rf"case Unexpected::{key}:\s*return \"([^\"]*)\"", source).group(1)
        assert f'{key} = "{name}"' in lua, name


def main():
    check_slot_times()
    check_unexpected()
    with Folder() as folder:
        compare(folder, HERE / "telegrams.log", 150)
        compare(folder, every_code(folder.path / "codes.log"), 2000)
        compare(folder, random_frames(folder.path / "random.log"), 6000)
        check_simulated_line(folder)


main()
