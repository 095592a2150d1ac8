"""DICOM: a file in each transfer syntax that is read, of several frames, enhanced, of colours; and series in folders."""

import io
import struct

import imagecodecs
import numpy
import pydicom
from pydicom.dataset import Dataset, FileMetaDataset
from pydicom.encaps import encapsulate
from pydicom.uid import UID

from packed import VALUES, several

NATIVE = ["1.2.840.10008.1.2", "1.2.840.10008.1.2.1", "1.2.840.10008.1.2.2", "1.2.840.10008.1.2.1.99"]
RLE = "1.2.840.10008.1.2.5"
GREY = numpy.arange(16 * 16, dtype="u1").reshape(16, 16)
COLOUR = numpy.arange(16 * 16 * 3, dtype="u1").reshape(16, 16, 3)
COMPRESSED = [
    ("1.2.840.10008.1.2.4.50", GREY, imagecodecs.jpeg8_encode),
    ("1.2.840.10008.1.2.4.50", COLOUR, imagecodecs.jpeg8_encode),
    ("1.2.840.10008.1.2.4.70", GREY.astype("u2") * 200, imagecodecs.ljpeg_encode),
    ("1.2.840.10008.1.2.4.80", GREY.astype("u2") * 200, imagecodecs.jpegls_encode),
    ("1.2.840.10008.1.2.4.80", COLOUR, imagecodecs.jpegls_encode),
    ("1.2.840.10008.1.2.4.90", GREY.astype("u2") * 200, lambda v: imagecodecs.jpeg2k_encode(v, level=0, codecformat="j2k")),
    ("1.2.840.10008.1.2.4.91", COLOUR, lambda v: imagecodecs.jpeg2k_encode(v, level=40, codecformat="jp2")),
]


def dataset(syntax, pixels, frames=1, **more):
    """A slice, or several frames, with no pixels yet."""
    data = Dataset()
    data.file_meta = FileMetaDataset()
    data.file_meta.TransferSyntaxUID = UID(syntax)
    data.SOPClassUID, data.SOPInstanceUID, data.SeriesInstanceUID = "1.2.840.10008.5.1.4.1.1.4", "1.2.3.1", "1.2.3"
    data.Modality, data.InstanceNumber = "MR", 1
    data.ImagePositionPatient, data.ImageOrientationPatient = [1, 2, 3], [1, 0, 0, 0, 1, 0]
    data.PixelSpacing, data.SpacingBetweenSlices = [0.5, 0.25], 2
    size = pixels.shape[-3:-1] if pixels.shape[-1] == 3 else pixels.shape[-2:]
    data.Rows, data.Columns = size
    data.SamplesPerPixel = 3 if pixels.shape[-1] == 3 else 1
    data.PhotometricInterpretation = "RGB" if data.SamplesPerPixel == 3 else "MONOCHROME2"
    if data.SamplesPerPixel == 3:
        data.PlanarConfiguration = 0
    if frames > 1:
        data.NumberOfFrames = frames
    data.BitsAllocated = data.BitsStored = 8 * pixels.itemsize
    data.HighBit, data.PixelRepresentation = data.BitsStored - 1, int(pixels.dtype.kind == "i")
    for name, value in more.items():
        setattr(data, name, value)
    return data


def file(data, native=None, streams=None):
    """Its bytes, with pixels as they are or compressed."""
    if streams is None:
        order = "<" if data.file_meta.TransferSyntaxUID.is_little_endian else ">"
        data.PixelData = native.astype(native.dtype.newbyteorder(order)).tobytes()
    else:
        data.PixelData = encapsulate(streams)
    data["PixelData"].VR = "OB" if streams or data.BitsAllocated == 8 else "OW"
    data.preamble = bytes(128)
    stream = io.BytesIO()
    pydicom.dcmwrite(stream, data, enforce_file_format=False)
    return stream.getvalue()


def rle(plane):
    """A frame of runs: a segment a byte, the most significant first, each all literal."""
    parts = numpy.moveaxis(plane, -1, 0) if plane.ndim == 3 else plane[None]
    segments = [part.astype(part.dtype.newbyteorder(">")).view("u1").reshape(-1, part.itemsize)[:, n] for part in parts for n in range(part.itemsize)]
    runs = [b"".join(bytes([len(part) - 1]) + part.tobytes() for part in numpy.split(s, range(100, s.size, 100))) for s in segments]
    runs = [run + bytes(len(run) % 2) for run in runs]
    starts = [64 + sum(map(len, runs[:n])) for n in range(len(runs))]
    words = [len(runs), *starts, *[0] * (15 - len(runs))]
    return struct.pack("<16I", *words) + b"".join(runs)


def slices(syntax, pixels, **more):
    """A series, in a folder."""
    files = {}
    for n, page in enumerate(pixels):
        place = dict(SOPInstanceUID=f"1.2.3.{n}", InstanceNumber=n, ImagePositionPatient=[1, 2, 3.0 * n])
        data = dataset(syntax, page, **place, **more)
        files[f"s{n}"] = file(data, page) if syntax in NATIVE else file(data, streams=[rle(page)])
    return several(files)


def item(**elements):
    data = Dataset()
    for name, value in elements.items():
        setattr(data, name, value)
    return data


def enhanced():
    """Frames whose places stand in functional groups."""
    shared = item(
        PixelMeasuresSequence=[item(PixelSpacing=[0.5, 0.25], SliceThickness=2)],
        PlaneOrientationSequence=[item(ImageOrientationPatient=[1, 0, 0, 0, 1, 0])],
    )
    frame = lambda n: item(
        PlanePositionSequence=[item(ImagePositionPatient=[1, 2, 2.0 * n])],
        PixelValueTransformationSequence=[item(RescaleSlope=2, RescaleIntercept=n)],
    )
    data = dataset(NATIVE[1], VALUES, len(VALUES), SharedFunctionalGroupsSequence=[shared])
    data.PerFrameFunctionalGroupsSequence = [frame(n) for n in range(len(VALUES))]
    del data.ImagePositionPatient, data.ImageOrientationPatient, data.PixelSpacing
    return file(data, VALUES)


def palette(table, kind=""):
    """Indices into tables of colours: entry by entry, or of the kind `Segmented`."""
    more = dict(PhotometricInterpretation="PALETTE COLOR")
    for name in ["Red", "Green", "Blue"]:
        more[f"{name}PaletteColorLookupTableDescriptor"] = [256, 0, 16]
        more[f"{kind}{name}PaletteColorLookupTableData"] = numpy.array(table, "<u2").tobytes()
    return file(dataset(NATIVE[1], GREY, **more), GREY)


def dicom():
    for syntax in NATIVE:
        yield file(dataset(syntax, VALUES[0], BitsStored=12, HighBit=11, RescaleSlope=1, RescaleIntercept=-1024), VALUES[0])
    for pixels in [VALUES[0], GREY, COLOUR]:
        yield file(dataset(RLE, pixels), streams=[rle(pixels)])
    for syntax, pixels, encode in COMPRESSED:
        yield file(dataset(syntax, pixels), streams=[encode(pixels)])
    yield file(dataset(NATIVE[1], VALUES, len(VALUES)), VALUES)
    yield file(dataset(NATIVE[0], VALUES, len(VALUES), GridFrameOffsetVector=[0, 2, 4], DoseGridScaling=0.5), VALUES)
    yield file(dataset(NATIVE[1], COLOUR, PlanarConfiguration=1), numpy.moveaxis(COLOUR, 2, 0))
    yield enhanced()
    yield palette(numpy.arange(256) * 200)
    yield palette([0, 2, 5, 10, 1, 100, 60000, 2, 2, 0, 0, 1, 80, 0], "Segmented")
    yield slices(NATIVE[1], VALUES)
    yield slices(RLE, VALUES, RescaleSlope=0.5, RescaleIntercept=0)
