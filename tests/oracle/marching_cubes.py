"""Runs vtkMarchingCubes for each request on standard input.

A request is a line of JSON - type, dims, spacing, origin, direction (9 numbers, by rows), iso, one_bucket - and the voxels
after it. vtkMergePoints looks for points of equal 32-bit coordinates in buckets found from 64-bit ones, so it misses some
that lie on both sides of a bucket's border; with one bucket it finds all. The answer is two 64-bit counts, the points and the normals as 32-bit floats, and the triangles as 32-bit numbers of points.
"""

import json
import sys

import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

TYPES = {"u8": "u1", "i8": "i1", "u16": "u2", "i16": "i2", "u32": "u4", "i32": "i4", "f32": "f4", "f64": "f8"}


def image(request, stream):
    kind = np.dtype("<" + TYPES[request["type"]])
    count = int(np.prod(request["dims"]))
    voxels = np.frombuffer(stream.read(count * kind.itemsize), kind)
    data = vtk.vtkImageData()
    data.SetDimensions(*request["dims"])
    data.SetSpacing(*request["spacing"])
    data.SetOrigin(*request["origin"])
    data.SetDirectionMatrix(*request["direction"])
    data.GetPointData().SetScalars(numpy_to_vtk(voxels, deep=True))
    return data


def mesh(data, iso, one_bucket):
    cubes = vtk.vtkMarchingCubes()
    cubes.SetInputData(data)
    cubes.SetValue(0, iso)
    cubes.ComputeNormalsOn()
    cubes.ComputeScalarsOff()
    if one_bucket:
        locator = vtk.vtkMergePoints()
        locator.AutomaticOff()
        locator.SetDivisions(1, 1, 1)
        cubes.SetLocator(locator)
    cubes.Update()
    return cubes.GetOutput()


def answer(surface, stream):
    points = np.zeros((0, 3), "<f4")
    normals = points
    triangles = np.zeros((0, 3), "<u4")
    if surface.GetNumberOfPoints() > 0:
        points = vtk_to_numpy(surface.GetPoints().GetData()).astype("<f4", copy=False)
        normals = vtk_to_numpy(surface.GetPointData().GetNormals()).astype("<f4", copy=False)
    if surface.GetNumberOfCells() > 0:
        triangles = vtk_to_numpy(surface.GetPolys().GetConnectivityArray()).astype("<u4")
    stream.write(np.array([len(points), len(triangles.reshape(-1, 3))], "<u8").tobytes())
    for part in (points, normals, triangles):
        stream.write(np.ascontiguousarray(part).tobytes())
    stream.flush()


def main():
    # Thin volumes are refused with a message on the error stream; what counts here is the empty mesh.
    vtk.vtkObject.GlobalWarningDisplayOff()
    while line := sys.stdin.buffer.readline():
        request = json.loads(line)
        answer(mesh(image(request, sys.stdin.buffer), request["iso"], request["one_bucket"]), sys.stdout.buffer)


main()
