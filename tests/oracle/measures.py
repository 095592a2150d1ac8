"""Measures each mesh on standard input with VTK.

A request is a line of JSON - points, triangles: how many - and after it the points as 32-bit floats and the triangles as
32-bit numbers of points. The answer is a line of JSON: area and volume of vtkMassProperties, the numbers of triangles of each
region and the CRC-32 of the points of the largest region's triangles by vtkPolyDataConnectivityFilter, and the numbers of
boundary and non-manifold edges of vtkFeatureEdges.
"""

import json
import sys
import zlib

import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy


def polydata(points, triangles):
    places = vtk.vtkPoints()
    places.SetData(numpy_to_vtk(points, deep=True))
    cells = vtk.vtkCellArray()
    cells.SetData(3, numpy_to_vtkIdTypeArray(triangles.astype("i8").ravel(), deep=True))
    surface = vtk.vtkPolyData()
    surface.SetPoints(places)
    surface.SetPolys(cells)
    return surface


def mass(surface):
    properties = vtk.vtkMassProperties()
    properties.SetInputData(surface)
    properties.Update()
    return {"area": properties.GetSurfaceArea(), "volume": properties.GetVolume()}


def regions(surface):
    connectivity = vtk.vtkPolyDataConnectivityFilter()
    connectivity.SetInputData(surface)
    connectivity.SetExtractionModeToAllRegions()
    connectivity.Update()
    sizes = vtk_to_numpy(connectivity.GetRegionSizes()).tolist()
    connectivity.SetExtractionModeToLargestRegion()
    connectivity.Update()
    largest = connectivity.GetOutput()
    corners = vtk_to_numpy(largest.GetPolys().GetConnectivityArray())
    coordinates = vtk_to_numpy(largest.GetPoints().GetData())[corners]
    return {"regions": sizes, "largest": zlib.crc32(coordinates.tobytes())}


def edges(surface, kind):
    features = vtk.vtkFeatureEdges()
    features.SetInputData(surface)
    for other in ("BoundaryEdges", "NonManifoldEdges", "ManifoldEdges", "FeatureEdges"):
        getattr(features, other + ("On" if other == kind else "Off"))()
    features.Update()
    return features.GetOutput().GetNumberOfLines()


def main():
    stream = sys.stdin.buffer
    while line := stream.readline():
        request = json.loads(line)
        points = np.frombuffer(stream.read(request["points"] * 12), "<f4").reshape(-1, 3)
        triangles = np.frombuffer(stream.read(request["triangles"] * 12), "<u4").reshape(-1, 3)
        surface = polydata(points, triangles)
        found = mass(surface) | regions(surface)
        found["boundary"] = edges(surface, "BoundaryEdges")
        found["non_manifold"] = edges(surface, "NonManifoldEdges")
        print(json.dumps(found), flush=True)


main()
