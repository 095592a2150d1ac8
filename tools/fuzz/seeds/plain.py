"""Formats whose files are a header and numbers: NRRD, NIfTI, MetaImage, VolPack and raw files."""

import bz2
import gzip
import struct
import zlib

from packed import VALUES, several


def text():
    return " ".join(map(str, VALUES.flat)).encode()


def nrrd():
    head = "NRRD0005\ntype: short\ndimension: 3\nsizes: 5 4 3\nendian: little\nencoding: %s\n"
    place = "space: left-posterior-superior\nspace directions: (1,0,0) (0,2,0) (0,0,3)\nspace origin: (1,2,3)\n"
    data = VALUES.tobytes()
    yield (head % "raw" + place).encode() + b"\n" + data
    yield (head % "gzip" + "spacings: 1 2 3\nbyte skip: 0\n").encode() + b"\n" + gzip.compress(data)
    yield (head % "bzip2" + "axis mins: 0 0 0\ncenters: node cell node\n").encode() + b"\n" + bz2.compress(data)
    yield (head % "text").encode() + b"\n" + text()
    yield (head % "hex").encode() + b"\n" + data.hex().encode()
    vectors = "NRRD0005\ntype: uchar\ndimension: 4\nsizes: 5 4 3 2\nkinds: vector domain domain time\nendian: big\nencoding: raw\n\n"
    yield vectors.encode() + data
    detached = (head % "raw" + "line skip: 1\nbyte skip: -1\ndata file: a.raw\n").encode()
    yield several({"a.nhdr": detached, "a.raw": b"x\n" + data}, "a.nhdr")
    slices = {f"s{n}": VALUES[n].tobytes() for n in range(3)}
    yield several({"a.nhdr": (head % "raw" + "data file: s%d 0 2 1 2\n").encode(), **slices}, "a.nhdr")
    yield several({"a.nhdr": (head % "raw" + "data file: LIST\ns0\ns1\ns2\n").encode(), **slices}, "a.nhdr")


def nifti_1(magic, offset, slope=0.0, order="<"):
    header = bytearray(348)
    struct.pack_into(order + "i", header, 0, 348)
    struct.pack_into(order + "8h", header, 40, 3, 5, 4, 3, 1, 1, 1, 1)
    struct.pack_into(order + "2h", header, 70, 4, 16)
    struct.pack_into(order + "8f", header, 76, 1, 1, 2, 3, 1, 1, 1, 1)
    struct.pack_into(order + "3f", header, 108, offset, slope, 1)
    struct.pack_into("<B", header, 123, 2)
    struct.pack_into(order + "2h6f12f", header, 252, 1, 1, 0, 0, 0, 1, 2, 3, 1, 0, 0, 4, 0, 2, 0, 5, 0, 0, 3, 6)
    header[344:348] = magic
    return bytes(header)


def nifti_2():
    header = bytearray(540)
    struct.pack_into("<i8s2h", header, 0, 540, b"n+2\0\r\n\032\n", 4, 16)
    struct.pack_into("<8q", header, 16, 4, 5, 4, 3, 1, 1, 1, 1)
    struct.pack_into("<8d", header, 104, -1, 1, 2, 3, 1, 1, 1, 1)
    struct.pack_into("<q2d", header, 168, 544, 2, 1)
    struct.pack_into("<2i6d", header, 344, 1, 0, 0.5, 0.5, 0.5, 1, 2, 3)
    struct.pack_into("<i", header, 500, 2)
    return bytes(header) + bytes(4)


def nifti():
    data = VALUES.tobytes()
    single = nifti_1(b"n+1\0", 352, 2.0) + bytes(4) + data
    yield single
    yield gzip.compress(single)
    yield several({"a.hdr": nifti_1(b"ni1\0", 0), "a.img": data}, "a.hdr")
    yield several({"a.hdr": nifti_1(bytes(4), 0), "a.img.gz": gzip.compress(data)}, "a.hdr")
    yield nifti_1(b"n+1\0", 352, order=">") + bytes(4) + VALUES.astype(">i2").tobytes()
    yield nifti_2() + data


def metaimage_header(data_file, extra="", sizes="5 4 3", kind="MET_SHORT"):
    count = len(sizes.split())
    matrix = " ".join(str(int(i % (count + 1) == 0)) for i in range(count * count))
    numbers = lambda values: " ".join(values[:count])
    return (
        f"ObjectType = Image\nNDims = {count}\nBinaryData = True\nBinaryDataByteOrderMSB = False\nTransformMatrix = {matrix}\n"
        f"Offset = {numbers(['1', '2', '3', '4'])}\nElementSpacing = {numbers(['1', '2', '3', '1'])}\nDimSize = {sizes}\n"
        f"{extra}ElementType = {kind}\nElementDataFile = {data_file}\n"
    ).encode()


def metaimage():
    data, packed = VALUES.tobytes(), zlib.compress(VALUES.tobytes())
    yield metaimage_header("LOCAL") + data
    yield metaimage_header("LOCAL", f"CompressedData = True\nCompressedDataSize = {len(packed)}\n") + packed
    yield metaimage_header("LOCAL", "ElementNumberOfChannels = 3\n", "5 4", "MET_USHORT_ARRAY") + data
    yield metaimage_header("LOCAL", "HeaderSize = -1\n", "5 2 3 2") + data
    yield metaimage_header("LOCAL").replace(b"BinaryData = True", b"BinaryData = False") + text()
    yield several({"a.mhd": metaimage_header("a.raw", "HeaderSize = 3\n"), "a.raw": b"abc" + data}, "a.mhd")
    yield several({"a.mhd": metaimage_header("a.zraw", "CompressedData = True\n"), "a.zraw": packed}, "a.mhd")
    slices = {f"s{n}": VALUES[n].tobytes() for n in range(3)}
    yield several({"a.mhd": metaimage_header("LIST") + b"s0\ns1\ns2\n", **slices}, "a.mhd")
    yield several({"a.mhd": metaimage_header("s%d 0 2 1"), **slices}, "a.mhd")


def volpack():
    for order in "<>":
        sizes = [0, 0, 0, 4, 3, 2, 5, 4, 3]
        yield struct.pack(order + "h27hhhi", 1, *sizes * 3, 0, 0, 60)[:58] + struct.pack(order + "i", 60) + VALUES.astype("u1").tobytes()


def raw():
    yield bytes(7) + VALUES.tobytes()
    yield bytes(7) + VALUES.astype(">i2").tobytes() + bytes(9)
