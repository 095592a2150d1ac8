"""Zarr: an array for each way through the reader, and an image of two levels."""

import pathlib
import tempfile

import numcodecs
import zarr

from packed import VALUES, of_folder


def options():
    for codec in [None, numcodecs.GZip(), numcodecs.Zlib(), numcodecs.Zstd(), numcodecs.LZ4(), numcodecs.BZ2()]:
        yield dict(zarr_format=2, compressors=codec)
    for name in ["blosclz", "lz4", "zlib", "zstd"]:
        yield dict(zarr_format=2, compressors=numcodecs.Blosc(name, shuffle=numcodecs.Blosc.BITSHUFFLE), order="F")
    yield dict(zarr_format=2, filters=[numcodecs.Delta("<i2"), numcodecs.Shuffle(2)], compressors=numcodecs.Zstd())
    yield dict(compressors=[zarr.codecs.ZstdCodec(), zarr.codecs.Crc32cCodec()], filters=[zarr.codecs.TransposeCodec(order=(2, 0, 1))])
    yield dict(dtype="<f2", compressors=None)
    yield dict(shards=(4, 4, 6), compressors=[zarr.codecs.GzipCodec()])


def image(path):
    axes = [{"name": name, "type": "space", "unit": "micrometer"} for name in "zyx"]
    scale = [{"type": "scale", "scale": [3, 2, 1]}, {"type": "translation", "translation": [1, 2, 3]}]
    levels = [{"path": level, "coordinateTransformations": scale} for level in "01"]
    ome = {"version": "0.5", "multiscales": [{"axes": axes, "datasets": levels}]}
    group = zarr.open_group(str(path), mode="w", attributes={"ome": ome})
    for level in "01":
        group.create_array(level, data=VALUES, chunks=(2, 4, 5))


def arrays():
    for way in options():
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "a"
            array = zarr.create_array(store=str(path), shape=(3, 4, 5), chunks=(2, 4, 3), fill_value=7, **{"dtype": "<i2", **way})
            array[1:] = VALUES[1:]
            yield of_folder(path)
    with tempfile.TemporaryDirectory() as folder:
        image(pathlib.Path(folder))
        yield of_folder(pathlib.Path(folder))
