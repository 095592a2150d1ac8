"""Moves points by vtkThinPlateSplineTransform with the basis R.

A request is a line of JSON - landmarks, points: how many - and after it, as 64-bit floats, the landmarks' places, where they go, and
the points. The answer is a line of JSON: where the points go, and by the inverse where they come from.
"""

import json
import sys

import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk


def vtk_points(places):
    points = vtk.vtkPoints()
    points.SetDataTypeToDouble()
    points.SetData(numpy_to_vtk(places, deep=True))
    return points


def spline(before, after):
    transform = vtk.vtkThinPlateSplineTransform()
    transform.SetBasisToR()
    transform.SetSourceLandmarks(vtk_points(before))
    transform.SetTargetLandmarks(vtk_points(after))
    transform.SetInverseTolerance(1e-10)
    transform.SetInverseIterations(1000)
    return transform


def moved(transform, places):
    return [transform.TransformPoint(place) for place in places]


def main():
    stream = sys.stdin.buffer
    while line := stream.readline():
        request = json.loads(line)
        read = lambda n: np.frombuffer(stream.read(24 * n), "f8").reshape(n, 3)
        before, after = read(request["landmarks"]), read(request["landmarks"])
        points = read(request["points"]).tolist()
        transform = spline(before, after)
        answer = {"forward": moved(transform, points), "inverse": moved(transform.GetInverse(), points)}
        print(json.dumps(answer), flush=True)


if __name__ == "__main__":
    main()
