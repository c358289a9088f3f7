"""The DBC file of a configuration, read by canmatrix, decodes the frames of that line.

line.toml has values as doublewords, a value whose words do not stand side by side, a low word and a high word alone,
and names that are none in a DBC file. Its line runs in virtual time (line_capture); the actual values that the master
had at the end are what the DBC file must make of the last telegrams of each slave, scaled.
"""
import os
import subprocess

from captures import HERE, Folder

import canmatrix.formats

CONFIG = HERE / "line.toml"


def physical(frame, data):
    """Every signal of a frame by name, scaled; the multiplexer chooses as canmatrix says."""
    return {name: decoded.phys_value for name, decoded in frame.decode(data).items()}


def frames_of(log):
    for line in log.read_text().splitlines():
        time, interface, frame = line.split()
        identifier, data = frame.split("#")
        if interface != "sync":
            yield time, int(identifier, 16), bytes.fromhex(data)


def load(folder, *options):
    text = folder.run(os.environ["CANSYNCD"], "--print-dbc", CONFIG, *options)
    path = folder.path / "line.dbc"
    path.write_bytes(text)
    return canmatrix.formats.loadp_flat(str(path), dbcImportEncoding="iso-8859-1",
                                        dbcImportCommentEncoding="iso-8859-1")


def check_messages(bus):
    identifiers = {frame.arbitration_id.id: frame.name for frame in bus.frames}
    asked = {n: name for n, name in [(0, "0"), (1, "winder"), (2, "2"), (3, "cutter_2"), (127, "nobody")]}
    expected = {0x010: "action_command"}
    for n, name in asked.items():
        expected[0x100 + n], expected[0x180 + n] = f"WRC1_{name}", f"WRC2_{name}"
    for n in (1, 3):
        for base, channel in ((0x300, "RDC1"), (0x380, "RDC2"), (0x500, "CC"), (0x580, "RC")):
            expected[base + n] = f"{channel}_{asked[n]}"
    assert identifiers == expected, identifiers
    winder = bus.frame_by_name("RDC1_winder")
    assert winder.transmitters == ["winder"] and winder.size == 8
    assert str(winder.comment) == "actual values of slave 1"
    oil = winder.signals[1]
    assert (oil.name, oil.unit, float(oil.factor), oil.is_signed) == ("Temperatur__l", "°C", 0.1, True)
    assert oil.comment == "Temperatur Öl"
    assert bus.ecu_by_name("cutter_2").comment == "cutter 2"


def check_reference_values(bus, frames):
    """give_references of line_capture writes 1000 + 10 * edge into every value; speed is a tenth of it."""
    seen = 0
    for _, identifier, data in frames:
        if identifier >> 7 == 2 and data:
            values = physical(bus.frame_by_id(canmatrix.ArbitrationId(identifier)), data)
            raw = int.from_bytes(data[:4], "little", signed=True)
            assert abs(float(values["speed"]) - raw * 0.1) < 1e-6 and raw >= 1000 and raw % 10 == 0
            seen += 1
    assert seen > 500, seen


def check_actual_values(bus, frames, master):
    """What the last RDC1 and RDC2 of each slave say is what the master took from them."""
    last = {identifier: data for _, identifier, data in frames if identifier >> 8 == 3}
    one = physical(bus.frame_by_name("RDC1_winder"), last[0x301])
    two = physical(bus.frame_by_name("RDC2_winder"), last[0x381])
    close = lambda got, raw, factor=1.0, offset=0.0: abs(float(got) - (raw * factor + offset)) < 1e-6
    assert close(one["position"], master[1, 0], 0.001, -5.0), one
    assert close(one["Temperatur__l"], master[1, 1], 0.1), one
    assert close(two["value4"], master[1, 4]) and close(two["value5"], master[1, 5]), two
    assert master[1, 0] != 0 and master[1, 1] != 0 and master[1, 5] != 0, "nothing to compare"
    # Slave 3: the low word of 0 alone, value 1 in two words, the high word of 2 alone.
    cutter = physical(bus.frame_by_name("RDC1_cutter_2"), last[0x303])
    assert close(cutter["position_low"], master[3, 0], 0.001, -5.0), cutter
    assert close(float(cutter["value1_high"]) + float(cutter["value1_low"]), master[3, 1]), cutter
    assert close(cutter["torque_high"], master[3, 2], 0.5), cutter


def check_negative(bus):
    """Signed values, and halves of them, by hand: -2 is FE FF FF FF."""
    winder = physical(bus.frame_by_name("RDC1_winder"), bytes.fromhex("FEFFFFFF FFFFFFFF"))
    assert abs(float(winder["position"]) + 5.002) < 1e-6 and abs(float(winder["Temperatur__l"]) + 0.1) < 1e-6
    # Words: low of 0, high of 1, low of 1, high of 2.
    cutter = physical(bus.frame_by_name("RDC1_cutter_2"), bytes.fromhex("0A00 FFFF FEFF FEFF"))
    assert abs(float(cutter["position_low"]) + 4.99) < 1e-6
    assert float(cutter["value1_high"]) + float(cutter["value1_low"]) == -2.0
    assert float(cutter["torque_high"]) == -2 * 65536 * 0.5


def check_commands(bus, folder, log):
    """Parameter numbers, offsets and the kind of each command and answer are those that `cansync trace` tells."""
    seen = {"parameter": 0, "transfer": 0}
    for told in folder.traced(log):
        if told["channel"] not in ("CC", "RC") or told["slave"] is None:
            continue
        frame = bus.frame_by_id(canmatrix.ArbitrationId(told["identifier"]))
        # The file gives every message its greatest length; canmatrix wants so many bytes.
        signals = frame.decode(bytes(told["data"]).ljust(frame.size, b"\0"))
        kind = signals["kind"].named_value
        assert kind == ("transfer" if told["data"][0] & 0x80 else "parameter"), told
        number = (told["data"][0] & 0x0F) << 8 | told["data"][1]
        field = "number" if kind == "parameter" else "length_or_offset"
        assert signals[field].raw_value == number, told
        if kind == "parameter":
            assert f"parameter {number}" in told["text"], told
        seen[kind] += 1
    assert min(seen.values()) > 20, seen


def check_refusals():
    """A wrong configuration gives no half file, and the exit code of --check."""
    wrong = subprocess.run([os.environ["CANSYNCD"], "--print-dbc", CONFIG, "--set", "bus.bit_rate=1"],
                           capture_output=True, check=False)
    assert wrong.returncode == 78 and wrong.stdout == b"" and b"bit_rate" in wrong.stderr, wrong


def main():
    check_refusals()
    with Folder() as folder:
        bus = load(folder)
        check_messages(bus)
        log = folder.path / "line.log"
        told = folder.run(os.environ["LINE_CAPTURE"], CONFIG, log).decode().splitlines()
        master = {(int(slave), int(value)): int(raw) for slave, value, raw in
                  (line.split() for line in told if not line.startswith("block"))}
        frames = list(frames_of(log))
        check_reference_values(bus, frames)
        check_actual_values(bus, frames, master)
        check_negative(bus)
        check_commands(bus, folder, log)


main()
