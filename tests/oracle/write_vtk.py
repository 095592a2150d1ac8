"""Writes images with VTK and says what VTK reads of them.

A request is a line of JSON, with the voxels after it:
{"path", "type", "components", "of": "points" | "cells", "extent": [6], "spacing": [3], "origin": [3], "direction": [9],
 "bytes": how many follow, "active": whether the array is the scalars,
 "writer": "xml" | "legacy", and for xml "mode": "ascii" | "binary" | "appended", "encode": whether appended data is base64,
 "compressor": null | "zlib" | "lz4" | "lzma", "wide": 64-bit headers, "order": "little" | "big", "block": bytes, "pieces";
 for legacy "binary", "version": 42 | 51}
The answer is a line of JSON, {"first": [3], "count"}: where the first point or cell centre is, and how many values there are.
A request without a writer is a file to read: {"path", "of"}; its answer has "array" too, and the values as 64-bit floats follow.
"""

import json
import sys

import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

TYPES = {"u8": "u1", "i8": "i1", "u16": "u2", "i16": "i2", "u32": "u4", "i32": "i4", "f32": "f4", "f64": "f8", "i64": "i8", "u64": "u8"}
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
    writer = vtk.vtkXMLImageDataWriter()
    writer.SetInputData(data)
    writer.SetFileName(request["path"])
    {"ascii": writer.SetDataModeToAscii, "binary": writer.SetDataModeToBinary, "appended": writer.SetDataModeToAppended}[request["mode"]]()
    writer.SetEncodeAppendedData(request["encode"])
    writer.SetCompressor(COMPRESSORS[request["compressor"]]() if request["compressor"] else None)
    writer.SetHeaderTypeToUInt64() if request["wide"] else writer.SetHeaderTypeToUInt32()
    writer.SetByteOrderToBigEndian() if request["order"] == "big" else writer.SetByteOrderToLittleEndian()
    writer.SetBlockSize(request["block"])
    writer.SetNumberOfPieces(request["pieces"])
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
    reader = vtk.vtkXMLImageDataReader() if path.endswith(".vti") else vtk.vtkStructuredPointsReader()
    reader.SetFileName(path)
    reader.Update()
    return reader.GetOutput()


def main():
    while line := sys.stdin.buffer.readline():
        request = json.loads(line)
        of = request["of"]
        values = b""
        if "writer" in request:
            data = image(request, sys.stdin.buffer)
            write_xml(request, data) if request["writer"] == "xml" else write_legacy(request, data)
            data = read(request["path"])
            count = attributes(data, of).GetArray("some values").GetNumberOfTuples()
            answer = {"first": first(data, of), "count": count}
        else:
            data = read(request["path"])
            array = attributes(data, of).GetScalars() or attributes(data, of).GetArray(0)
            numbers = vtk_to_numpy(array).astype("<f8").ravel()
            values = numbers.tobytes()
            answer = {"first": first(data, of), "count": len(numbers), "array": array.GetName(), "spacing": list(data.GetSpacing())}
        sys.stdout.buffer.write(json.dumps(answer).encode() + b"\n" + values)
        sys.stdout.buffer.flush()


main()
