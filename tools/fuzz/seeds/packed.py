"""What all seeds are made of: a few values, and inputs of several files as tools/fuzz/input.rs unpacks them."""

import pathlib
import struct
import tempfile

import numpy

VALUES = (numpy.arange(3 * 4 * 5, dtype="<i2") - 20).reshape(3, 4, 5)


def several(files, opened=""):
    """An input of several files, of which one is opened, or their folder."""
    name = lambda text: bytes([len(text)]) + text.encode()
    contents = [name(path) + struct.pack("<I", len(data)) + data for path, data in files.items()]
    return b"FILES" + name(opened) + b"".join(contents)


def of_folder(path):
    return several({str(p.relative_to(path)): p.read_bytes() for p in sorted(path.rglob("*")) if p.is_file()})


def written(write, name):
    """The bytes of the file of this name that `write` writes."""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / name
        write(str(path))
        return path.read_bytes()
