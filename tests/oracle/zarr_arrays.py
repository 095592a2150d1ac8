"""Writes arrays with zarr-python, and the voxels of each beside it, little-endian, x fastest.

A line of JSON asks: {"folder": ...}. The answer is a list of {"name", "path", "type", "dims", "voxels"} and, where the reader has to be
told which volume is meant, "frame" and "component".
"""

import json
import pathlib
import sys

import numcodecs
import numpy
import zarr
from zarr.codecs import BloscCodec, BytesCodec, Crc32cCodec, GzipCodec, ShardingCodec, TransposeCodec, ZstdCodec

SHAPE = (21, 34, 45)
CHUNKS = (8, 16, 12)
TYPES = ["u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", "f2", "f4", "f8"]


def voxels(dtype, shape=SHAPE, seed=7):
    """Smooth values with noise, and a large part that is the fill value 3."""
    random = numpy.random.default_rng(seed)
    values = random.normal(50, 20, shape) + numpy.arange(shape[-1])
    values = values.clip(0, 120).astype(dtype)
    values[..., : shape[-2] // 2, :] = 3
    if dtype.kind == "f":
        values[..., -1, -1, -1] = numpy.nan
    return values



class Cases:
    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.cases = []

    def add(self, name, dtype="u2", shape=SHAPE, fill=3, select=(), **options):
        """Writes an array; `select` is the (frame, component) that the reader is told."""
        values = voxels(numpy.dtype(dtype), shape)
        path = self.folder / f"{len(self.cases)}.zarr"
        options.setdefault("chunks", CHUNKS[-len(shape):])
        array = zarr.create_array(store=str(path), shape=shape, dtype=values.dtype, fill_value=fill, **options)
        array[...] = values
        volume = values[tuple(select)]
        expected = self.folder / f"{len(self.cases)}.raw"
        if volume.dtype.kind == "f" and volume.dtype.itemsize == 2:
            volume = volume.astype("f4")
        little = volume.astype(volume.dtype.newbyteorder("<"))
        expected.write_bytes(numpy.ascontiguousarray(little).tobytes())
        dims = list(volume.shape[::-1])
        case = {"name": name, "path": str(path), "type": volume.dtype.str[1:], "voxels": str(expected)}
        case["dims"] = dims + [1] * (3 - len(dims))
        case["frame"], case["component"] = [*select, None, None][:2] if len(select) == 2 else (None, [*select, None][0])
        self.cases.append(case)


def version_2(cases):
    for dtype in TYPES:
        for order in "<>":
            cases.add(f"2 {order}{dtype}", order + dtype, zarr_format=2, compressors=None)
    compressors = [numcodecs.GZip(), numcodecs.Zlib(), numcodecs.Zstd(), numcodecs.LZ4(), numcodecs.BZ2()]
    for name in ["blosclz", "lz4", "lz4hc", "zlib", "zstd"]:
        for shuffle in [numcodecs.Blosc.NOSHUFFLE, numcodecs.Blosc.SHUFFLE, numcodecs.Blosc.BITSHUFFLE]:
            compressors.append(numcodecs.Blosc(name, 5, shuffle))
    for compressor in compressors:
        for dtype in ["u1", "i2", "f8"]:
            cases.add(f"2 {compressor} {dtype}", dtype, zarr_format=2, compressors=compressor)
    # Blocks of Blosc: a chunk of several, the last one shorter.
    for compressor in compressors[5:]:
        cases.add(f"2 blocks {compressor}", "u4", (61, 70, 83), zarr_format=2, compressors=compressor, chunks=(60, 64, 81))
    for dtype in ["|u1", "<i2", ">u2", "<i4", ">i8"]:
        delta = numcodecs.Delta(dtype)
        shuffle = numcodecs.Shuffle(numpy.dtype(dtype).itemsize)
        for filters in [[delta], [shuffle], [delta, shuffle]]:
            cases.add(f"2 {filters} {dtype}", dtype, zarr_format=2, filters=filters, compressors=numcodecs.Zstd())
        cases.add(f"2 only a filter {dtype}", dtype, zarr_format=2, filters=[delta], compressors=None)
    cases.add("2 Fortran", ">i2", zarr_format=2, compressors=numcodecs.Zstd(), order="F")
    cases.add("2 folders", zarr_format=2, chunk_key_encoding={"name": "v2", "separator": "/"})
    cases.add("2 plane", shape=(34, 45), zarr_format=2, fill=0)
    cases.add("2 four axes", shape=(2, *SHAPE), zarr_format=2, chunks=(1, *CHUNKS), select=(1,))
    cases.add("2 five axes", shape=(2, 3, *SHAPE), zarr_format=2, chunks=(2, 2, *CHUNKS), select=(1, 2))


def version_3(cases):
    for dtype in TYPES:
        cases.add(f"3 {dtype}", dtype, compressors=None)
    codecs = [GzipCodec(), ZstdCodec(), BloscCodec(cname="lz4"), BloscCodec(cname="zstd", shuffle="bitshuffle"), Crc32cCodec()]
    for codec in codecs:
        cases.add(f"3 {type(codec).__name__}", compressors=[codec])
    cases.add("3 two codecs", compressors=[ZstdCodec(), Crc32cCodec()])
    cases.add("3 big", "i4", serializer=BytesCodec(endian="big"))
    cases.add("3 transposed", filters=[TransposeCodec(order=(1, 2, 0))])
    cases.add("3 dots", chunk_key_encoding={"name": "default", "separator": "."})
    cases.add("3 keys of 2", chunk_key_encoding={"name": "v2", "separator": "/"})
    shards = tuple(2 * n for n in CHUNKS)
    cases.add("3 shards", shards=shards)
    cases.add("3 shards of four axes", shape=(3, *SHAPE), chunks=(1, *CHUNKS), shards=(2, *shards), select=(2,))
    for place in ["start", "end"]:
        inner = [TransposeCodec(order=(2, 1, 0)), BytesCodec(endian="big"), GzipCodec()]
        sharding = ShardingCodec(chunk_shape=CHUNKS, codecs=inner, index_location=place)
        cases.add(f"3 shards, index at the {place}", "f4", serializer=sharding, chunks=shards, compressors=None)


def main():
    for line in sys.stdin:
        cases = Cases(json.loads(line)["folder"])
        version_2(cases)
        version_3(cases)
        print(json.dumps(cases.cases), flush=True)


main()
