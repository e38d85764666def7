"""Writes one measurement in the formats of laboratories, each with the tools' own writers.

    python tests/formats/laboratory_files.py FOLDER            the files alone
    STICKSLIP=target/release/stickslip python tests/formats/laboratory_files.py FOLDER --table benches/import-formats.md

Every entry of `FILES` writes a file and says what is expected of it: the numbers of the measurement (`READ`), or a sentence with
some word (`REFUSED`). The measurement is a loop of a contact: time, displacement and force at 2048 Hz.
"""

import os
import struct
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pyuff
import scipy.io
from nptdms import ChannelObject, GroupObject, RootObject, TdmsFile, TdmsWriter

RATE = 2048.0
N = 1024
T = np.arange(N) / RATE
U = 1e-4 * np.sin(2 * np.pi * 8 * T + 0.2)
F = 60.0 * np.tanh(3 * np.cos(2 * np.pi * 8 * T)) + 2.0 * np.sin(2 * np.pi * 100 * T)
TRUE = {"time": T, "displacement": U, "force": F}
# How a column is told where the file cannot hold its unit.
COLUMNS = ["--column", "time=time [s]", "--column", "displacement=displacement [m]", "--column", "force=force [N]"]
UNITS = {"time": "s", "displacement": "mm", "force": "kN"}
SCALED = {"time": T, "displacement": U * 1e3, "force": F * 1e-3}

FILES = []


def written(name, what, *arguments, refused=None, digits=9, records=1):
    """Registers a writer: the file `name`, `what` it is; `refused` holds a word of the sentence."""

    def register(write):
        FILES.append({"name": name, "what": what, "write": write, "arguments": list(arguments),
                      "refused": refused, "digits": digits, "records": records})
        return write

    return register


def frame(data=SCALED, style="{name} [{unit}]", units=UNITS):
    return pd.DataFrame({style.format(name=name, unit=units[name]): values for name, values in data.items()})


# Text, written by pandas and numpy.
for number, (style, options, what) in enumerate([
    ("{name} [{unit}]", {}, "commas"),
    ("{name} ({unit})", {"sep": ";"}, "semicolons"),
    ("{name} ({unit})", {"sep": ";", "decimal": ","}, "semicolons, decimal comma"),
    ("{name}_{unit}", {"sep": "\t"}, "tabs"),
    ("{name}_{unit}", {"sep": "\t", "decimal": ","}, "tabs, decimal comma"),
    ("{name} / {unit}", {"sep": ";", "lineterminator": "\r\n"}, "CR-LF"),
    ("{name} [{unit}]", {"encoding": "utf-16"}, "UTF-16"),
    ("{name} [{unit}]", {"encoding": "utf-8-sig"}, "byte order mark"),
    ("{name} [{unit}]", {"quoting": 1}, "quoted"),
    ("{name} [{unit}]", {"index": True}, "an index beside"),
]):
    @written(f"pandas-{number}.csv", f"pandas `to_csv`, {what}")
    def _(path, style=style, options=options):
        frame(style=style).to_csv(path, **{"index": False, **options})


@written("numpy.txt", "numpy `savetxt`, names behind `#`")
def _(path):
    np.savetxt(path, np.column_stack(list(SCALED.values())), delimiter=",", header="time [s],displacement [mm],force [kN]", fmt="%.15e")


@written("numpy-blanks.dat", "numpy `savetxt`, blanks")
def _(path):
    np.savetxt(path, np.column_stack(list(SCALED.values())), header="time_s displacement_mm force_kN", comments="", fmt="%.15e")


@written("preamble.csv", "lines of the instrument above, a row of units")
def _(path):
    with open(path, "w") as file:
        file.write("Instrument;DAQ 3\nDate;12.03.2026\nRate;2048\n\nTime;Displacement;Force\ns;mm;kN\n")
        frame().to_csv(file, sep=";", index=False, header=False)


@written("gaps.csv", "NaN in some rows", records=2)
def _(path):
    table = frame()
    table.iloc[500, 2] = np.nan
    table.to_csv(path, index=False)


@written("no-units.csv", "no units", refused="no unit")
def _(path):
    pd.DataFrame(TRUE).to_csv(path, index=False)


@written("told-units.csv", "no units, told by `--column`", *COLUMNS)
def _(path):
    pd.DataFrame(TRUE).to_csv(path, index=False)


@written("reversed.csv", "force with the other sign, told", "--column", "Kraft=-force [kN]")
def _(path):
    pd.DataFrame({"time [s]": T, "displacement [mm]": U * 1e3, "Kraft": -F * 1e-3}).to_csv(path, index=False)


@written("numbers-alone.csv", "no heading", refused="names the columns")
def _(path):
    pd.DataFrame(TRUE).to_csv(path, index=False, header=False)


@written("table.xlsx", "a workbook", refused="save the sheet as CSV")
def _(path):
    import zipfile
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("xl/workbook.xml", "<workbook/>")


@written("array.npy", "numpy `save`", refused="NumPy")
def _(path):
    np.save(path, np.column_stack(list(TRUE.values())))


# MAT, version 5, written by scipy.
NAMED = {f"{name}_{UNITS[name]}": values for name, values in SCALED.items()}


@written("vectors.mat", "scipy `savemat`, vectors `force_kN`")
def _(path):
    scipy.io.savemat(path, NAMED)


@written("compressed.mat", "scipy, compressed")
def _(path):
    scipy.io.savemat(path, NAMED, do_compression=True)


@written("columns.mat", "scipy, column vectors", *COLUMNS)
def _(path):
    scipy.io.savemat(path, TRUE, oned_as="column")


@written("struct.mat", "scipy, a struct of vectors")
def _(path):
    scipy.io.savemat(path, {"measurement": NAMED})


@written("struct-units.mat", "scipy, a struct with a struct of units")
def _(path):
    scipy.io.savemat(path, {"run": {**SCALED, "units": UNITS}})


@written("struct-array.mat", "scipy, an array of structs, two records", records=2)
def _(path):
    kind = [(name, object) for name in NAMED]
    both = np.zeros(2, dtype=kind)
    for row in range(2):
        for name, values in NAMED.items():
            both[row][name] = values
    scipy.io.savemat(path, {"runs": both})


@written("nested.mat", "scipy, structs in a struct, two records", records=2)
def _(path):
    scipy.io.savemat(path, {"data": {"first": NAMED, "second": NAMED}})


@written("matrix.mat", "scipy, a matrix with names and units in cells")
def _(path):
    cell = lambda texts: np.array(texts, dtype=object)
    scipy.io.savemat(path, {"data": np.column_stack(list(SCALED.values())), "names": cell(list(SCALED)), "units": cell(list(UNITS.values()))})


@written("rate.mat", "scipy, a rate in place of time stamps")
def _(path):
    scipy.io.savemat(path, {"fs": RATE, "displacement_mm": U * 1e3, "force_kN": F * 1e-3})


@written("signals.mat", "scipy, a struct per signal with `data`, `unit`, `fs`")
def _(path):
    signal = lambda name: {"data": SCALED[name], "unit": UNITS[name], "fs": RATE}
    scipy.io.savemat(path, {"displacement": signal("displacement"), "force": signal("force")})


@written("single.mat", "scipy, single precision", digits=6)
def _(path):
    scipy.io.savemat(path, {**NAMED, "displacement_mm": np.float32(U * 1e3), "force_kN": np.float32(F * 1e-3)})


@written("integers.mat", "scipy, counts of a converter, told", "--column", "counts=force [mN]", digits=4)
def _(path):
    scipy.io.savemat(path, {"time_s": T, "displacement_mm": U * 1e3, "counts": np.int32(np.round(F * 1e3))})


@written("version-4.mat", "scipy, version 4", refused="unknown format")
def _(path):
    scipy.io.savemat(path, NAMED, format="4")


@written("text-only.mat", "scipy, nothing but text", refused="no series")
def _(path):
    scipy.io.savemat(path, {"comment": "nothing here"})


def cut(path, keep):
    data = Path(path).read_bytes()
    Path(path).write_bytes(data[: int(len(data) * keep)])


@written("cut.mat", "scipy, the file cut off", refused="could not be read")
def _(path):
    scipy.io.savemat(path, NAMED)
    cut(path, 0.6)


# MAT, version 7.3: HDF5 behind 512 bytes, written by h5py as MATLAB lays it out.
def matlab(path, fill):
    with h5py.File(path, "w", userblock_size=512) as file:
        fill(file)
    with open(path, "r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")


def variable(group, name, values, **options):
    data = group.create_dataset(name, data=np.atleast_2d(values), **options)
    data.attrs["MATLAB_class"] = np.bytes_("double")
    return data


def letters(group, name, text):
    data = group.create_dataset(name, data=np.array([[ord(letter)] for letter in text], dtype="u2"))
    data.attrs["MATLAB_class"] = np.bytes_("char")
    data.attrs["MATLAB_int_decode"] = np.int32(2)
    return data


@written("vectors-73.mat", "h5py as MATLAB 7.3, vectors")
def _(path):
    matlab(path, lambda file: [variable(file, name, values) for name, values in NAMED.items()])


@written("struct-73.mat", "h5py as MATLAB 7.3, a struct, compressed")
def _(path):
    def fill(file):
        group = file.create_group("measurement")
        group.attrs["MATLAB_class"] = np.bytes_("struct")
        for name, values in NAMED.items():
            variable(group, name, values, compression="gzip", chunks=(1, 256))
    matlab(path, fill)


@written("units-73.mat", "h5py as MATLAB 7.3, texts `force_unit`")
def _(path):
    def fill(file):
        for name, values in SCALED.items():
            variable(file, name, values)
            letters(file, f"{name}_unit", UNITS[name])
    matlab(path, fill)


@written("cells-73.mat", "h5py as MATLAB 7.3, a struct array by references, two records", records=2)
def _(path):
    def fill(file):
        store = file.create_group("#refs#")
        runs = file.create_group("runs")
        runs.attrs["MATLAB_class"] = np.bytes_("struct")
        for name, values in NAMED.items():
            both = [variable(store, f"{name}{run}", values).ref for run in range(2)]
            runs.create_dataset(name, data=np.array([both], dtype=h5py.ref_dtype), dtype=h5py.ref_dtype)
    matlab(path, fill)


# HDF5, written by h5py.
def attributed(group, **options):
    for name, values in SCALED.items():
        data = group.create_dataset(name, data=values, **options)
        data.attrs["units"] = UNITS[name]


for number, (options, settings, what) in enumerate([
    ({}, {}, "units as attributes"),
    ({"compression": "gzip"}, {}, "gzip"),
    ({"compression": "gzip", "shuffle": True, "fletcher32": True}, {}, "gzip, shuffled, with checksums"),
    ({"compression": "lzf"}, {}, "LZF"),
    ({"chunks": (100,), "maxshape": (None,)}, {}, "chunks that may grow"),
    ({}, {"libver": "latest"}, "newest layout"),
    ({"dtype": ">f8"}, {}, "big-endian"),
]):
    @written(f"attributes-{number}.h5", f"h5py, {what}")
    def _(path, options=options, settings=settings):
        with h5py.File(path, "w", **settings) as file:
            attributed(file, **options)


@written("groups.h5", "h5py, a group per record, two records", records=2)
def _(path):
    with h5py.File(path, "w") as file:
        for run in ["run1", "run2"]:
            attributed(file.create_group(run))


@written("compound.h5", "h5py, a table of structures")
def _(path):
    kind = [(f"{name} [{unit}]", "f8") for name, unit in UNITS.items()]
    table = np.zeros(N, dtype=kind)
    for name, unit in UNITS.items():
        table[f"{name} [{unit}]"] = SCALED[name]
    with h5py.File(path, "w") as file:
        file["measurement"] = table


@written("matrix.h5", "h5py, a matrix with names and units as attributes")
def _(path):
    with h5py.File(path, "w") as file:
        data = file.create_dataset("data", data=np.column_stack(list(SCALED.values())))
        data.attrs["names"] = list(SCALED)
        data.attrs["units"] = list(UNITS.values())


@written("rate.h5", "h5py, a rate as attribute")
def _(path):
    with h5py.File(path, "w") as file:
        for name in ["displacement", "force"]:
            data = file.create_dataset(name, data=SCALED[name])
            data.attrs["unit"] = UNITS[name]
        file.attrs["sample_rate"] = RATE


@written("plain.h5", "h5py, no units", refused="no unit")
def _(path):
    with h5py.File(path, "w") as file:
        for name, values in TRUE.items():
            file[name] = values


@written("cut.h5", "h5py, the file cut off", refused="could not be read")
def _(path):
    with h5py.File(path, "w") as file:
        attributed(file)
    cut(path, 0.5)


# Universal files, written by pyuff.
KINDS = {"displacement": 8, "force": 13}


def functions(path, names=("displacement", "force"), data=SCALED, units=True, even=1, node=0, double=True, function=1, binary=0):
    file = pyuff.UFF(str(path))
    for name in names:
        file.write_sets({
            "type": 58, "binary": binary, "func_type": function, "rsp_node": node, "rsp_dir": 3, "ref_node": 0, "ref_dir": 0,
            "data": data[name], "x": T, "id1": name, "abscissa_spacing": even, "abscissa_spec_data_type": 17,
            "ordinate_spec_data_type": KINDS[name], "orddenom_spec_data_type": 0, "z_axis_axis_lab": "NONE",
            "ordinate_axis_units_lab": UNITS[name] if units else "NONE", "ord_data_type": 4 if double else 2,
            "abscissa_axis_units_lab": "s",
        }, "add", force_double=double)


# A universal file holds its step with six digits.
@written("even.uff", "pyuff 58, text, even steps", digits=5)
def _(path):
    functions(path)


@written("single.uff", "pyuff 58, text, single precision", digits=5)
def _(path):
    functions(path, double=False)


@written("uneven.uff", "pyuff 58, text, pairs", digits=5)
def _(path):
    functions(path, even=0)


@written("binary.uff", "pyuff 58b, binary, even steps", digits=5)
def _(path):
    functions(path, binary=1)


@written("binary-uneven.uff", "pyuff 58b, binary, pairs", digits=5)
def _(path):
    functions(path, binary=1, even=0)


@written("units.uff", "pyuff 58 behind 164 (SI) without labels", digits=5)
def _(path):
    pyuff.UFF(str(path)).write_sets({"type": 164, "units_code": 1, "units_description": "SI", "temp_mode": 1, "length": 1.0,
                                     "force": 1.0, "temp": 1.0, "temp_offset": 0.0})
    functions(path, data=TRUE, units=False)


@written("two-runs.uff", "pyuff 58, two records", digits=5, records=2)
def _(path):
    functions(path)
    functions(path)


@written("frf.uff", "pyuff 58, frequency response functions", refused="only time responses")
def _(path):
    functions(path, function=4)


@written("unitless.uff", "pyuff 58, no units", refused="no unit")
def _(path):
    functions(path, units=False)


# TDMS, written by npTDMS.
def channels(group, data=SCALED, units=True, waveform=False, **more):
    names = [name for name in data if not (waveform and name == "time")]
    properties = lambda name: {
        **({"unit_string": UNITS[name]} if units else {}),
        **({"wf_increment": 1 / RATE, "wf_start_offset": 0.0, "wf_samples": N} if waveform else {}),
        **more,
    }
    return [ChannelObject(group, name, data[name], properties=properties(name)) for name in names]


def tdms(path, *segments):
    with TdmsWriter(str(path)) as writer:
        for segment in segments:
            writer.write_segment(segment)


@written("channels.tdms", "npTDMS, units as properties")
def _(path):
    tdms(path, channels("loop"))


@written("waveform.tdms", "npTDMS, waveforms with an increment")
def _(path):
    tdms(path, [RootObject({"author": "rig"}), GroupObject("loop"), *channels("loop", waveform=True)])


@written("segments.tdms", "npTDMS, in four segments")
def _(path):
    part = lambda k: {name: values[k * 256:(k + 1) * 256] for name, values in SCALED.items()}
    tdms(path, *[channels("loop", part(k)) for k in range(4)])


@written("groups.tdms", "npTDMS, two groups, two records", records=2)
def _(path):
    tdms(path, channels("run 1") + channels("run 2"))


@written("single.tdms", "npTDMS, single precision", digits=6)
def _(path):
    tdms(path, channels("loop", {**SCALED, "displacement": np.float32(U * 1e3), "force": np.float32(F * 1e-3)}))


@written("unitless.tdms", "npTDMS, no units, told", *COLUMNS)
def _(path):
    tdms(path, channels("loop", TRUE, units=False))


@written("plain.tdms", "npTDMS, no units", refused="no unit")
def _(path):
    tdms(path, channels("loop", TRUE, units=False))


@written("cut.tdms", "npTDMS, the file cut off", refused="could not be read")
def _(path):
    tdms(path, channels("loop"))
    cut(path, 0.7)


# TDMS as loggers write it, which npTDMS does not: samples in turn, big-endian, many blocks. npTDMS reads the same.
def logged(path, interleaved=False, big_endian=False, rows=N, codes=(10, 10, 10)):
    order = ">" if big_endian else "<"
    words = lambda text: struct.pack(order + "I", len(text)) + text.encode()
    kinds = [np.dtype(order + {10: "f8", 9: "f4", 3: "i4"}[code]) for code in codes]
    table = [np.asarray(values).astype(kind) for values, kind in zip(SCALED.values(), kinds)]
    metadata = struct.pack(order + "I", len(table))
    for name, code in zip(SCALED, codes):
        metadata += words(f"/'loop'/'{name}'") + struct.pack(order + "IIIQ", 20, code, 1, rows)
        metadata += struct.pack(order + "I", 1) + words("unit_string") + struct.pack(order + "I", 32) + words(UNITS[name])
    data = b""
    for first in range(0, N, rows):
        block = [values[first:first + rows] for values in table]
        data += b"".join(values[row:row + 1].tobytes() for row in range(rows) for values in block) if interleaved else b"".join(values.tobytes() for values in block)
    contents = 14 | interleaved << 5 | big_endian << 6
    path.write_bytes(b"TDSm" + struct.pack("<I", contents) + struct.pack(order + "IQQ", 4713, len(metadata + data), len(metadata)) + metadata + data)
    judge = TdmsFile.read(path)["loop"]
    assert all(np.array_equal(judge[name][:], values) for name, values in zip(SCALED, table))


for name, what, options, digits in [
    ("interleaved", "samples in turn", {"interleaved": True}, 9),
    ("big-endian", "big-endian", {"big_endian": True}, 9),
    ("blocks", "sixteen blocks in a segment", {"rows": N // 16}, 9),
    ("logger", "samples in turn, big-endian, in blocks, of two kinds", {"interleaved": True, "big_endian": True, "rows": N // 16, "codes": (10, 9, 9)}, 6),
]:
    @written(f"{name}.tdms", f"by hand, {what}, checked by npTDMS", digits=digits)
    def _(path, options=options):
        logged(path, **options)


# Parquet, written by pandas and pyarrow.
for number, (options, what) in enumerate([
    ({}, "Snappy"),
    ({"compression": None}, "not compressed"),
    ({"compression": "gzip"}, "gzip"),
    ({"compression": "lz4"}, "LZ4"),
    ({"index": True}, "an index beside"),
    ({"use_dictionary": False, "data_page_version": "2.0"}, "pages of version 2"),
    ({"row_group_size": 100}, "eleven groups of rows"),
]):
    @written(f"pandas-{number}.parquet", f"pandas `to_parquet`, {what}")
    def _(path, options=options):
        frame().to_parquet(path, **options)


@written("zstd.parquet", "pandas, Zstandard", refused="compression='snappy'")
def _(path):
    frame().to_parquet(path, compression="zstd")


@written("single.parquet", "pyarrow, single precision and integers", digits=4)
def _(path):
    table = pa.table({"time [s]": T, "displacement [mm]": pa.array(U * 1e3, pa.float32()), "force [mN]": pa.array(np.round(F * 1e3), pa.int32())})
    pq.write_table(table, path)


@written("nulls.parquet", "pyarrow, values missing", records=2)
def _(path):
    force = [None if row == 500 else value for row, value in enumerate(F * 1e-3)]
    pq.write_table(pa.table({"time [s]": T, "displacement [mm]": U * 1e3, "force [kN]": force}), path)


@written("stamps.parquet", "pyarrow, stamps of date and time", digits=8)
def _(path):
    stamps = pa.array(np.int64(np.round(T * 1e9)) + 1_773_000_000_000_000_000, pa.timestamp("ns"))
    pq.write_table(pa.table({"time": stamps, "displacement [mm]": U * 1e3, "force [kN]": F * 1e-3}), path)


def write(folder):
    """All files, into `folder`."""
    folder.mkdir(parents=True, exist_ok=True)
    for one in FILES:
        one["write"](folder / one["name"])


def imported(stickslip, folder, one):
    """What the program makes of a file: its answer, and the records as tables."""
    out = folder / (one["name"] + ".data")
    answer = subprocess.run([stickslip, "import", one["name"], "-o", out.name, *one["arguments"]], cwd=folder,
                            capture_output=True, text=True, check=False)
    records = [pd.read_csv(path) for path in sorted(out.glob("*.csv"))] if answer.returncode == 0 else []
    return answer, records


def problem(one, answer, records):
    """What is wrong with the answer; empty where nothing is."""
    if one["refused"]:
        good = answer.returncode == 2 and one["refused"] in answer.stderr and "panicked" not in answer.stderr
        return "" if good else f"not refused with `{one['refused']}`: {answer.returncode} {answer.stderr or answer.stdout}"
    if answer.returncode != 0:
        return answer.stderr
    if len(records) != one["records"]:
        return f"{len(records)} records: {answer.stdout}"
    # A record that is cut at a gap holds the rows of its stretch.
    for record in records:
        start = int(round(record["time [s]"].iloc[0] * RATE)) if len(record) < N else 0
        for name, unit in [("time", "s"), ("displacement", "m"), ("force", "N")]:
            read, true = record[f"{name} [{unit}]"].to_numpy(), TRUE[name][start:start + len(record)]
            if name == "time" and len(record) == N:
                read = read - read[0]
            error = np.abs(read - true).max() / np.abs(TRUE[name]).max()
            if not error < 10.0 ** -one["digits"]:
                return f"{name} is off by {error:.1e}"
    return ""


def table(stickslip, folder):
    """The page: a row per file."""
    rows, wrong = [], 0
    for one in FILES:
        answer, records = imported(stickslip, folder, one)
        bad = problem(one, answer, records)
        wrong += bool(bad)
        told = " ".join(line.strip() for line in answer.stderr.replace("\n  ", " ").splitlines() if line.strip())
        result = f"**{bad}**" if bad else told.replace("|", "\\|") if one["refused"] else f"read, {one['digits']} digits" + (
            f", {one['records']} records" if one["records"] > 1 else "")
        rows.append(f"| `{one['name']}` | {one['what']} | {result} |")
    head = ("# Files as laboratories export them\n\nA loop of 1024 samples, written by pandas, numpy, scipy, h5py, pyuff, npTDMS and pyarrow, and read by "
            "`stickslip import`. Read means: to the same numbers, relative to the largest, up to the digits that are named (fewer where the file "
            "holds fewer). Made by `tests/formats/laboratory_files.py` (its head says how); the tests run the same.\n\n"
            f"{len(FILES)} files, {wrong} with another result than expected.\n\n| file | written by | result |\n|---|---|---|\n")
    return head + "\n".join(rows) + "\n", wrong


if __name__ == "__main__":
    place = Path(sys.argv[1])
    write(place)
    if "--table" in sys.argv:
        text, wrong = table(os.path.abspath(os.environ["STICKSLIP"]), place)
        Path(sys.argv[sys.argv.index("--table") + 1]).write_text(text)
        sys.exit(wrong > 0)
