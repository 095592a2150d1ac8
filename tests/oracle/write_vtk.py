"""Writes images with VTK and says what VTK reads of them.

A request is a line of JSON, with the voxels after it:
{"path", "type", "components", "of": "points" | "cells", "extent": [6], "spacing": [3], "origin": [3], "direction": [9],
 "bytes": how many follow, "active": whether the array is the scalars,
 "writer": "xml" | "parallel" | "legacy", and for the first two "mode": "ascii" | "binary" | "appended", "encode": whether appended data is base64,
 "compressor": null | "zlib" | "lz4" | "lzma", "wide": 64-bit headers, "order": "little" | "big", "block": bytes, "pieces"; for
 parallel "ghosts": levels of them;
 for legacy "binary", "version": 42 | 51}
The answer is a line of JSON, {"first": [3], "count"}: where the first point or cell centre is, and how many values there are.
A request without a writer is a file to read: {"path", "of"}; its answer has "array" too, and the values as 64-bit floats follow.
"""

import json
import sys

import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

TYPES = {"bit": "u1", "u8": "u1", "i8": "i1", "u16": "u2", "i16": "i2", "u32": "u4", "i32": "i4", "f32": "f4", "f64": "f8", "i64": "i8", "u64": "u8"}
ARRAYS = {"i64": vtk.vtkTypeInt64Array, "u64": vtk.vtkTypeUInt64Array}
COMPRESSORS = {"zlib": vtk.vtkZLibDataCompressor, "lz4": vtk.vtkLZ4DataCompressor, "lzma": vtk.vtkLZMADataCompressor}


def attributes(image, of):
    return image.GetPointData() if of == "points" else image.GetCellData()


def image(request, stream):
    values = np.frombuffer(stream.read(request["bytes"]), "<" + TYPES[request["type"]])
    array = numpy_to_vtk(values.reshape(-1, request["components"]), deep=True)
    if request["type"] in ARRAYS:
        typed = ARRAYS[request["type"]]()
        typed.DeepCopy(array)
        array = typed
    if request["type"] == "bit":
        array = vtk.vtkBitArray()
        array.SetNumberOfComponents(request["components"])
        array.SetNumberOfTuples(values.size // request["components"])
        for index, bit in enumerate(values):
            array.SetValue(index, int(bit))
    array.SetName("some values")
    data = vtk.vtkImageData()
    data.SetExtent(*request["extent"])
    data.SetSpacing(*request["spacing"])
    data.SetOrigin(*request["origin"])
    data.SetDirectionMatrix(*request["direction"])
    where = attributes(data, request["of"])
    other = vtk.vtkFloatArray()
    other.SetName("other")
    other.SetNumberOfComponents(2)
    other.SetNumberOfTuples(array.GetNumberOfTuples())
    other.Fill(1.5)
    where.AddArray(other)
    where.AddArray(array)
    if request["active"]:
        where.SetActiveScalars("some values")
    return data


def write_xml(request, data):
    writer = vtk.vtkXMLPImageDataWriter() if request["writer"] == "parallel" else vtk.vtkXMLImageDataWriter()
    writer.SetInputData(data)
    writer.SetFileName(request["path"])
    {"ascii": writer.SetDataModeToAscii, "binary": writer.SetDataModeToBinary, "appended": writer.SetDataModeToAppended}[request["mode"]]()
    writer.SetEncodeAppendedData(request["encode"])
    writer.SetCompressor(COMPRESSORS[request["compressor"]]() if request["compressor"] else None)
    writer.SetHeaderTypeToUInt64() if request["wide"] else writer.SetHeaderTypeToUInt32()
    writer.SetByteOrderToBigEndian() if request["order"] == "big" else writer.SetByteOrderToLittleEndian()
    writer.SetBlockSize(request["block"])
    writer.SetNumberOfPieces(request["pieces"])
    if request["writer"] == "parallel":
        writer.SetEndPiece(request["pieces"] - 1)
        writer.SetGhostLevel(request["ghosts"])
    assert writer.Write() == 1


def write_legacy(request, data):
    writer = vtk.vtkStructuredPointsWriter()
    writer.SetInputData(data)
    writer.SetFileName(request["path"])
    writer.SetFileVersion(request["version"])
    writer.SetFileTypeToBinary() if request["binary"] else writer.SetFileTypeToASCII()
    assert writer.Write() == 1


def first(data, of):
    within = 0.5 if of == "cells" else 0.0
    place = [0.0] * 3
    data.TransformContinuousIndexToPhysicalPoint(*(n + within for n in data.GetExtent()[::2]), place)
    return place


def read(path):
    readers = {"vti": vtk.vtkXMLImageDataReader, "pvti": vtk.vtkXMLPImageDataReader, "vtk": vtk.vtkStructuredPointsReader}
    reader = readers[path.rsplit(".", 1)[1]]()
    reader.SetFileName(path)
    reader.Update()
    return reader.GetOutput()


def numbers_of(array):
    """All of them; vtk_to_numpy knows only bits of one component."""
    if isinstance(array, vtk.vtkBitArray):
        return np.array([array.GetValue(index) for index in range(array.GetNumberOfValues())], "<f8")
    return vtk_to_numpy(array).astype("<f8").ravel()


def main():
    while line := sys.stdin.buffer.readline():
        request = json.loads(line)
        of = request["of"]
        values = b""
        if "writer" in request:
            data = image(request, sys.stdin.buffer)
            write_legacy(request, data) if request["writer"] == "legacy" else write_xml(request, data)
            data = read(request["path"])
            count = attributes(data, of).GetArray("some values").GetNumberOfTuples()
            answer = {"first": first(data, of), "count": count}
        else:
            data = read(request["path"])
            array = attributes(data, of).GetScalars() or attributes(data, of).GetArray(0)
            numbers = numbers_of(array)
            values = numbers.tobytes()
            answer = {"first": first(data, of), "count": len(numbers), "array": array.GetName(), "spacing": list(data.GetSpacing())}
        sys.stdout.buffer.write(json.dumps(answer).encode() + b"\n" + values)
        sys.stdout.buffer.flush()


main()
