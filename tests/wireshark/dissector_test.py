"""The dissector's output of a capture with every telegram kind equals the expected text.

telegrams.log is written by hand from docs/cansync-protocol.md. expected/table.txt has a line for each of its frames,
expected/details.txt what Wireshark shows of one frame of each kind. Both were read beside the log and the tables of
that document, line by line, before they were kept; after a change, `dissector_test.py --write` writes them anew, to
be read again.
"""
import os
import random
import re
import struct
import subprocess
import sys

from captures import HERE, STARTS, Folder, differences

TABLE = ["frame.number", "cansync.channel", "cansync.slave", "cansync.text", "cansync.request_in", "cansync.response_in",
         "cansync.response_us", "cansync.repeats", "cansync.time_since_first_us", "cansync.after_sync_us",
         "cansync.latest_start_us", "cansync.transfer.block", "cansync.transfer.block_first", "_ws.expert.message"]
MAPPINGS = ["-o", "cansync.mapping_rdc1:01 03 05 07", "-o", "cansync.mapping_wrc1:0,0,2,3 / F,T,F,F"]
# One of each kind, in the numbers of tshark.
DETAILED = [1, 2, 4, 8, 9, 10, 17, 19, 26, 28, 29, 31, 55, 62, 67, 73, 80, 82, 116, 124, 128, 131, 144, 155, 157,
            163, 176, 180, 182, 183]


def table(folder, capture):
    rows = folder.fields(capture, TABLE, "-E", "occurrence=a")
    return ["|".join(row) for row in rows]


def details(folder, capture):
    """What stands under the protocol CANsync, frame by frame."""
    numbers = ",".join(str(number) for number in DETAILED)
    text = folder.run("tshark", "-2", "-Y", f"frame.number in {{{numbers}}}", "-r", capture, *STARTS, *MAPPINGS,
                      "-V").decode()
    out = []
    for number, frame in zip(DETAILED, re.split(r"^(?=Frame \d+:)", text, flags=re.M)[1:]):
        assert frame.startswith(f"Frame {number}:"), frame[:20]
        inside = re.search(r"^CANsync\n((?:    .*\n)*)", frame, flags=re.M)
        out.append(f"Frame {number}")
        out += inside.group(1).splitlines() if inside else ["    not CANsync"]
    return out


def frame_bits(identifier, data):
    """Bits of a standard data frame without interframe space, by the rules of CAN 2.0A."""
    bits = "0" + format(identifier, "011b") + "000" + format(len(data), "04b")
    bits += "".join(format(byte, "08b") for byte in data)
    crc = 0
    for bit in bits:
        crc <<= 1
        if int(bit) ^ (crc >> 15):
            crc ^= 0x4599
        crc &= 0x7FFF
    out, run = [], 0
    for bit in bits + format(crc, "015b"):
        run = run + 1 if out and out[-1] == bit else 1
        out.append(bit)
        if run == 5:
            out.append("1" if bit == "0" else "0")
            run = 1
    return len(out) + 10


def check_ends(folder):
    """Stamps of the kernel are ends of frames: each start is found from the bits of that very frame."""
    dice = random.Random(1)
    lines = ["(1.000000) sync 080#", "(1.001000) sync 080#"]
    begins = []
    for number in range(200):
        edge = 1_002_000 + 1000 * number
        identifier = dice.choice([0x100, 0x180, 0x300, 0x380]) + dice.randrange(32)
        data = bytes(dice.choice([0, 0xFF, 0x0F, 0xAA, dice.randrange(256)]) for _ in range(dice.choice([0, 2, 4, 6, 8])))
        lines.append(f"(1.{edge - 1_000_000:06}) sync 080#")
        lines.append(f"(1.{edge + 500 - 1_000_000:06}) can0 {identifier:03X}#{data.hex()}")
        begins.append(float(500 - frame_bits(identifier, data)))
    log = folder.path / "ends.log"
    log.write_text("\n".join(lines) + "\n")
    rows = folder.fields(folder.capture(log), ["cansync.channel", "cansync.after_sync_us"], "-o",
                         "cansync.stamps:end of the frame")
    assert [float(after) for channel, after in rows if channel != "SYNC"] == begins


def check_wrong_mapping(folder, capture):
    """A mapping that is none is named with what is allowed, and no value is shown."""
    for wrong in ("01 03 05", "02 00 00 00", "0,0,1,1 / F,T,F", "0,0,1,8 / F,T,F,T", "-1,0,1,1 / T,T,F,T", "nonsense"):
        done = subprocess.run(["tshark", "-o", f"cansync.mapping_rdc1:{wrong}", "-r", str(capture), "-c", "9", "-T", "fields",
                               "-e", "cansync.value"], capture_output=True, check=True,
                              env=dict(os.environ, HOME=str(folder.path)))
        assert f"mapping of RDC1: found '{wrong}'" in done.stderr.decode(), (wrong, done.stderr.decode())
        assert not done.stdout.split(), (wrong, done.stdout)


def pcapng_block(kind, body):
    """A block of a pcapng capture (draft-ietf-opsawg-pcapng, section 3.1)."""
    length = 12 + len(body)
    return struct.pack("<II", kind, length) + body + struct.pack("<I", length)


def check_can_fd(folder):
    """A CAN FD frame with the identifier of a telegram is none: CANsync is CAN 2.0."""
    frames = [struct.pack(">IB3x", 0x101, 8) + bytes(8),  # struct can_frame, its identifier as LINKTYPE_CAN_SOCKETCAN has it
              struct.pack(">IBB2x", 0x101, 8, 0x04) + bytes(64)]  # struct canfd_frame with CANFD_FDF
    capture = folder.path / "fd.pcapng"
    blocks = [pcapng_block(0x0A0D0D0A, struct.pack("<IHHq", 0x1A2B3C4D, 1, 0, -1)), pcapng_block(1, struct.pack("<HHI", 227, 0, 0))]
    blocks += [pcapng_block(6, struct.pack("<IIIII", 0, 0, 1000 * number, len(frame), len(frame)) + frame)
               for number, frame in enumerate(frames)]
    capture.write_bytes(b"".join(blocks))
    assert folder.fields(capture, ["cansync.channel", "can.id"]) == [["WRC1", "257"], ["", "257"]]


def main():
    log = HERE / "telegrams.log"
    with Folder() as folder:
        folders = folder.run("tshark", "-G", "folders").decode()
        assert os.environ["PLUGINS"] in folders, f"{os.environ['PLUGINS']} is not where this Wireshark looks:\n{folders}"
        capture = folder.capture(log)
        got = {"table.txt": table(folder, capture), "details.txt": details(folder, capture)}
        check_ends(folder)
        check_wrong_mapping(folder, capture)
        check_can_fd(folder)
    for name, lines in got.items():
        path = HERE / "expected" / name
        if sys.argv[1:] == ["--write"]:
            path.write_text("\n".join(lines) + "\n")
            continue
        expected = path.read_text().splitlines()
        assert lines == expected, f"{path}:\n{differences(expected, lines)}"


main()
