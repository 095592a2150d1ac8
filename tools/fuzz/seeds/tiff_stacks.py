"""TIFF, in each layout and compression that is read; and folders of slices."""

import io

import imagecodecs
import numpy
import tifffile

from packed import VALUES, several

COLOURS = numpy.arange(2 * 16 * 16 * 3, dtype="u1").reshape(2, 16, 16, 3)

WAYS = [
    dict(),
    dict(byteorder=">", bigtiff=True),
    dict(rowsperstrip=2, compression="zlib"),
    dict(compression="zlib", predictor=True),
    dict(compression="lzw"),
    dict(compression="packbits", byteorder=">"),
    dict(tile=(16, 16)),
    dict(tile=(16, 16), compression="lzw"),
    dict(tile=(16, 16), compression="zlib", predictor=True, bigtiff=True),
    dict(photometric="miniswhite", resolution=(300, 300), resolutionunit="inch"),
]


def tiff(values, **way):
    stream = io.BytesIO()
    tifffile.imwrite(stream, values, **{"photometric": "minisblack", "metadata": None, "software": False, **way})
    return stream.getvalue()


def stacks():
    for way in WAYS:
        yield tiff(VALUES.astype("u2"), **way)
    for kind in ["u1", "i4", "f2", "f4", "f8", "u8"]:
        yield tiff(VALUES.astype(kind), compression="zlib", predictor=kind in ["f4", "f8"])
    yield tiff(COLOURS, photometric="rgb")
    yield tiff(numpy.moveaxis(COLOURS, 3, 1), photometric="rgb", planarconfig="separate")
    yield tiff(COLOURS, photometric="rgb", compression="jpeg")
    yield tiff(COLOURS[..., 0], photometric="palette", colormap=numpy.zeros((3, 256), "u2"))
    hyper = VALUES.reshape(1, 3, 2, 2, 5).astype("u2")
    yield tiff(hyper, imagej=True, photometric=None, metadata={"axes": "TZCYX", "spacing": 3.0, "unit": "um"}, resolution=(2, 2))
    ome = {"axes": "TZCYX", "PhysicalSizeX": 0.5, "PhysicalSizeXUnit": "µm", "PhysicalSizeZ": 2.0}
    yield tiff(hyper, ome=True, photometric=None, metadata=ome)


def folders():
    pages = VALUES.astype("u1")
    kinds = {
        "png": [imagecodecs.png_encode(numpy.ascontiguousarray(page)) for page in pages],
        "jpg": [imagecodecs.jpeg8_encode(numpy.ascontiguousarray(page)) for page in pages],
        "tif": [tiff(page.astype("u2"), compression="lzw") for page in VALUES],
    }
    for end, files in kinds.items():
        yield several({f"s{n}.{end}": data for n, data in enumerate(files, 8)})
    yield several({f"{n}.png": imagecodecs.png_encode(page.astype("u2")) for n, page in enumerate(COLOURS)})
    # As one file, which is then taken for a PNG by its name.
    yield kinds["png"][0]
    yield kinds["jpg"][0]
