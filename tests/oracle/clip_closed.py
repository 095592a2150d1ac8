"""Runs vtkClipClosedSurface on a mesh from standard input.

The request is a line of JSON - points, triangles, through and normal of the plane whose front stays - then the points as 32-bit
floats and the triangles as 32-bit numbers of points. The answer is the area of what is left and that of the cap, as JSON.
"""

import json
import sys

import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy


def surface(request, stream):
    points = np.frombuffer(stream.read(12 * request["points"]), "<f4").reshape(-1, 3).astype("f8")
    triangles = np.frombuffer(stream.read(12 * request["triangles"]), "<u4").reshape(-1, 3)
    cells = np.hstack([np.full((len(triangles), 1), 3), triangles]).astype("i8").ravel()
    polys = vtk.vtkCellArray()
    polys.ImportLegacyFormat(numpy_to_vtkIdTypeArray(cells, deep=True))
    places = vtk.vtkPoints()
    places.SetDataTypeToDouble()
    places.SetData(numpy_to_vtk(points, deep=True))
    data = vtk.vtkPolyData()
    data.SetPoints(places)
    data.SetPolys(polys)
    return data


def clipped(data, request):
    plane = vtk.vtkPlane()
    plane.SetOrigin(*request["through"])
    plane.SetNormal(*request["normal"])
    planes = vtk.vtkPlaneCollection()
    planes.AddItem(plane)
    clip = vtk.vtkClipClosedSurface()
    clip.SetInputData(data)
    clip.SetClippingPlanes(planes)
    clip.SetScalarModeToLabels()
    # Relative to the data's size: only points that agree are merged.
    clip.SetTolerance(1e-12)
    triangles = vtk.vtkTriangleFilter()
    triangles.SetInputConnection(clip.GetOutputPort())
    triangles.Update()
    return triangles.GetOutput()


def areas(data):
    points = vtk_to_numpy(data.GetPoints().GetData()).astype("f8")
    a, b, c = points[vtk_to_numpy(data.GetPolys().GetConnectivityArray()).reshape(-1, 3)].transpose(1, 0, 2)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    label = vtk_to_numpy(data.GetCellData().GetScalars())
    return [float(area[label == 0].sum()), float(area[label != 0].sum())]


def main():
    request = json.loads(sys.stdin.buffer.readline())
    print(json.dumps(areas(clipped(surface(request, sys.stdin.buffer), request))))


main()
