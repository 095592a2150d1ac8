"""Writes small valid files of each format, from which fuzzing sets out: seeds.py FOLDER. One function a format, named as it is."""

import gzip
import pathlib
import struct
import sys
import tempfile

import numcodecs
import numpy
import zarr

VALUES = (numpy.arange(3 * 4 * 5, dtype="<i2") - 20).reshape(3, 4, 5)


def several(files, opened=""):
    """An input of several files, of which one is opened, or their folder."""
    name = lambda text: bytes([len(text)]) + text.encode()
    contents = [name(path) + struct.pack("<I", len(data)) + data for path, data in files.items()]
    return b"FILES" + name(opened) + b"".join(contents)


def nrrd():
    head = "NRRD0005\ntype: short\ndimension: 3\nsizes: 5 4 3\nendian: little\nencoding: %s\n"
    place = "space: left-posterior-superior\nspace directions: (1,0,0) (0,2,0) (0,0,3)\nspace origin: (1,2,3)\n"
    data = VALUES.tobytes()
    yield (head % "raw" + place).encode() + b"\n" + data
    yield (head % "gzip" + "spacings: 1 2 3\nbyte skip: 0\n").encode() + b"\n" + gzip.compress(data)
    yield (head % "text").encode() + b"\n" + " ".join(map(str, VALUES.flat)).encode()
    detached = (head % "raw" + "line skip: 1\nbyte skip: -1\ndata file: a.raw\n").encode()
    yield several({"a.nhdr": detached, "a.raw": b"x\n" + data}, "a.nhdr")


def nifti_header(magic, offset, slope=0.0):
    header = bytearray(348)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 3, 5, 4, 3, 1, 1, 1, 1)
    struct.pack_into("<2h", header, 70, 4, 16)
    struct.pack_into("<8f", header, 76, 1, 1, 2, 3, 1, 1, 1, 1)
    struct.pack_into("<3f", header, 108, offset, slope, 1)
    struct.pack_into("<B", header, 123, 2)
    struct.pack_into("<2h6f12f", header, 252, 1, 1, 0, 0, 0, 1, 2, 3, 1, 0, 0, 4, 0, 2, 0, 5, 0, 0, 3, 6)
    header[344:348] = magic
    return bytes(header)


def nifti_1():
    data = VALUES.tobytes()
    single = nifti_header(b"n+1\0", 352, 2.0) + bytes(4) + data
    yield single
    yield gzip.compress(single)
    yield several({"a.hdr": nifti_header(b"ni1\0", 0), "a.img": data}, "a.hdr")


def raw():
    yield bytes(7) + VALUES.tobytes()
    yield VALUES.tobytes()


def of_folder(path):
    return several({str(p.relative_to(path)): p.read_bytes() for p in sorted(path.rglob("*")) if p.is_file()})


def zarr_arrays():
    """Options of arrays, each of which takes another way through the reader."""
    for codec in [None, numcodecs.GZip(), numcodecs.Zlib(), numcodecs.Zstd(), numcodecs.LZ4()]:
        yield dict(zarr_format=2, compressors=codec)
    for name in ["blosclz", "lz4", "zlib", "zstd"]:
        yield dict(zarr_format=2, compressors=numcodecs.Blosc(name, shuffle=numcodecs.Blosc.BITSHUFFLE), order="F")
    yield dict(compressors=[zarr.codecs.ZstdCodec(), zarr.codecs.Crc32cCodec()], filters=[zarr.codecs.TransposeCodec(order=(2, 0, 1))])
    yield dict(shards=(4, 4, 6), compressors=[zarr.codecs.GzipCodec()])


def image(path):
    axes = [{"name": name, "type": "space", "unit": "micrometer"} for name in "zyx"]
    scale = [{"type": "scale", "scale": [3, 2, 1]}, {"type": "translation", "translation": [1, 2, 3]}]
    levels = [{"path": level, "coordinateTransformations": scale} for level in "01"]
    ome = {"version": "0.5", "multiscales": [{"axes": axes, "datasets": levels}]}
    group = zarr.open_group(str(path), mode="w", attributes={"ome": ome})
    for level in "01":
        group.create_array(level, data=VALUES, chunks=(2, 4, 5))


def zarr_():
    for options in zarr_arrays():
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "a"
            array = zarr.create_array(store=str(path), shape=(3, 4, 5), chunks=(2, 4, 3), dtype="<i2", fill_value=7, **options)
            array[1:] = VALUES[1:]
            yield of_folder(path)
    with tempfile.TemporaryDirectory() as folder:
        image(pathlib.Path(folder))
        yield of_folder(pathlib.Path(folder))


SEEDS = {"nrrd": nrrd, "nifti": nifti_1, "zarr": zarr_, "raw": raw}


def main():
    for name, seeds in SEEDS.items():
        folder = pathlib.Path(sys.argv[1]) / name
        folder.mkdir(parents=True, exist_ok=True)
        for n, data in enumerate(seeds()):
            (folder / f"{n:02}").write_bytes(data)


main()
