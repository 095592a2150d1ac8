"""Reads mesh files with VTK or trimesh and prints what they say, one JSON line a file; a float as the bits of its f32.

    target/deps/vtk/bin/python tests/oracle/read_mesh.py vtk head.ply trimesh head.ply …
"""

import json
import sys

import numpy as np
import trimesh
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOGeometry import vtkGLTFReader, vtkOBJReader, vtkSTLReader
from vtkmodules.vtkIOPLY import vtkPLYReader
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader

VTK_READERS = {
    "ply": vtkPLYReader,
    "stl": vtkSTLReader,
    "obj": vtkOBJReader,
    "glb": vtkGLTFReader,
    "vtp": vtkXMLPolyDataReader,
}


def plain(array):
    """An array as lists, its floats as bits. A reader of text has them in f64: they are rounded to f32."""
    if array is None:
        return None
    array = np.asarray(array)
    if array.dtype.kind == "f":
        array = np.ascontiguousarray(array, dtype=np.float32).view(np.uint32)
    return array.tolist()


def with_vtk(path):
    suffix = path.rsplit(".", 1)[-1]
    reader = VTK_READERS[suffix]()
    reader.SetFileName(path)
    if suffix == "stl":
        reader.MergingOff()
    if suffix == "glb":
        reader.ApplyDeformationsToGeometryOn()
    reader.Update()
    output = reader.GetOutput()
    if output.IsA("vtkPolyData"):
        return vtk_polydata(output) | {"space": vtk_space(reader, output)}
    return [vtk_polydata(block) for block in leaves(output)]


def leaves(blocks):
    """The datasets of a tree, in their order."""
    place = blocks.NewTreeIterator()
    place.InitTraversal()
    while not place.IsDoneWithTraversal():
        yield place.GetCurrentDataObject()
        place.GoToNextItem()


def vtk_polydata(polydata):
    count = polydata.GetNumberOfPoints()
    normals = polydata.GetPointData().GetNormals()
    triangles = vtk_to_numpy(polydata.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    return {
        "positions": plain(vtk_to_numpy(polydata.GetPoints().GetData())) if count else [],
        "normals": plain(vtk_to_numpy(normals)) if normals else None,
        "triangles": plain(triangles),
        "points": vtk_arrays(polydata.GetPointData()),
        "cells": vtk_arrays(polydata.GetCellData()),
    }


def vtk_space(reader, polydata):
    """Where the formats have a place for the frame: a header, comments, or a field."""
    if reader.IsA("vtkSTLReader"):
        return reader.GetHeader()
    if reader.IsA("vtkOBJReader"):
        return reader.GetComment()
    if reader.IsA("vtkPLYReader"):
        comments = reader.GetComments()
        return " ".join(comments.GetValue(n) for n in range(comments.GetNumberOfValues()))
    return "SPACE=" + polydata.GetFieldData().GetAbstractArray("SPACE").GetValue(0)


def vtk_arrays(data):
    numbers = range(data.GetNumberOfArrays())
    return {data.GetArrayName(n): plain(vtk_to_numpy(data.GetArray(n))) for n in numbers}


def trimesh_ply(path):
    elements = trimesh.load(path, process=False).metadata["_ply_raw"]
    vertex, face = elements["vertex"]["data"], elements["face"]["data"]
    corners = face["vertex_indices"]
    return {
        "positions": plain(columns(vertex, "x", "y", "z")),
        "normals": plain(columns(vertex, "nx", "ny", "nz")),
        "values": plain(column(vertex, "value")),
        "colors": plain(columns(vertex, "red", "green", "blue", "alpha")),
        "triangles": plain(corners["f1"]),
        "labels": plain(column(face, "label")),
    }


def column(table, name):
    return table[name].ravel() if name in table.dtype.names else None


def columns(table, *names):
    found = [column(table, name) for name in names]
    return None if any(c is None for c in found) else np.stack(found, axis=1)


def trimesh_stl(path):
    with open(path, "rb") as file:
        found = trimesh.exchange.stl.load_stl_binary(file)
    return {
        "positions": plain(found["vertices"]),
        "triangles": plain(found["faces"]),
        "facet_normals": plain(found["face_normals"]),
    }


def trimesh_obj(path):
    mesh = trimesh.load(path, process=False, maintain_order=True)
    return {
        "positions": plain(mesh.vertices),
        "normals": plain(mesh.vertex_normals),
        "colors": plain(mesh.visual.vertex_colors),
        "triangles": plain(mesh.faces),
    }


def trimesh_glb(path):
    """The primitives as they are stored, each with the node's matrix."""
    scene = trimesh.load(path, process=False)
    return [trimesh_primitive(scene, node) for node in scene.graph.nodes_geometry]


def trimesh_primitive(scene, node):
    matrix, name = scene.graph[node]
    mesh = scene.geometry[name]
    return {
        "positions": plain(mesh.vertices),
        "normals": plain(mesh.vertex_normals),
        "triangles": plain(mesh.faces),
        "matrix": matrix.tolist(),
    }


TRIMESH = {"ply": trimesh_ply, "stl": trimesh_stl, "obj": trimesh_obj, "glb": trimesh_glb}


def with_trimesh(path):
    return TRIMESH[path.rsplit(".", 1)[-1]](path)


READERS = {"vtk": with_vtk, "trimesh": with_trimesh}

if __name__ == "__main__":
    requests = sys.argv[1:]
    for reader, path in zip(requests[::2], requests[1::2]):
        print(json.dumps(READERS[reader](path)))
