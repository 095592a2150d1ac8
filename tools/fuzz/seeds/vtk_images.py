"""VTK's images, in every encoding and with every compressor."""

import numpy
import vtk
from vtk.util.numpy_support import numpy_to_vtk

from packed import VALUES, written

COMPRESSORS = [None, vtk.vtkZLibDataCompressor, vtk.vtkLZ4DataCompressor, vtk.vtkLZMADataCompressor]


def bits(values):
    array = vtk.vtkBitArray()
    for bit in values.ravel():
        array.InsertNextValue(int(bit))
    return array


def image(values=VALUES, of="points", components=1):
    data = vtk.vtkImageData()
    more = int(of == "cells")
    data.SetExtent(-1, 3 + more, 2, 5 + more, 0, values.size // 20 // components - 1 + more)
    data.SetSpacing(1, 2, 3)
    data.SetOrigin(4, 5, 6)
    array = bits(values) if values.dtype == bool else numpy_to_vtk(values.reshape(-1, components), deep=True)
    array.SetName("values")
    attributes = data.GetPointData() if of == "points" else data.GetCellData()
    attributes.SetScalars(array)
    return data


def xml_file(data, mode, compressor=None, encoded=False, wide=False, big=False, pieces=1):
    writer = vtk.vtkXMLImageDataWriter()
    writer.SetInputData(data)
    {"ascii": writer.SetDataModeToAscii, "binary": writer.SetDataModeToBinary, "appended": writer.SetDataModeToAppended}[mode]()
    writer.SetEncodeAppendedData(encoded)
    writer.SetCompressor(compressor() if compressor else None)
    writer.SetHeaderTypeToUInt64() if wide else writer.SetHeaderTypeToUInt32()
    writer.SetByteOrderToBigEndian() if big else writer.SetByteOrderToLittleEndian()
    # Several blocks, the last of which is not full.
    writer.SetBlockSize(32)
    writer.SetNumberOfPieces(pieces)

    def write(path):
        writer.SetFileName(path)
        assert writer.Write() == 1

    return written(write, "a.vti")


def xml():
    yield xml_file(image(), "ascii")
    for compressor in COMPRESSORS:
        yield xml_file(image(), "binary", compressor)
        yield xml_file(image(), "appended", compressor, wide=True)
        yield xml_file(image(), "appended", compressor, encoded=True, big=True)
    yield xml_file(image(), "appended", pieces=3)
    yield xml_file(image(of="cells"), "binary")
    yield xml_file(image(VALUES.astype("f4"), components=3), "ascii")
    yield xml_file(image(VALUES.astype("u1"), components=3), "appended")
    yield xml_file(image(VALUES % 2 == 1), "binary")


def legacy_file(data, binary, version=42):
    writer = vtk.vtkStructuredPointsWriter()
    writer.SetInputData(data)
    writer.SetFileVersion(version)
    writer.SetFileTypeToBinary() if binary else writer.SetFileTypeToASCII()

    def write(path):
        writer.SetFileName(path)
        assert writer.Write() == 1

    return written(write, "a.vtk")


def with_vectors():
    data = image(VALUES.astype("f4"))
    for name, add in [("v", data.GetPointData().SetVectors), ("n", data.GetPointData().SetNormals)]:
        array = numpy_to_vtk(numpy.ones((60, 3), "f4"), deep=True)
        array.SetName(name)
        add(array)
    return data


def legacy():
    for binary in [False, True]:
        for version in [42, 51]:
            yield legacy_file(image(), binary, version)
        yield legacy_file(image(of="cells"), binary)
        yield legacy_file(with_vectors(), binary)
        yield legacy_file(image(VALUES.astype("u1"), components=3), binary)
