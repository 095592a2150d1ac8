"""Times vtkImageReslice (linear) on a 256 cubed u8 volume deformed by a vtkThinPlateSplineTransform and prints JSON.

    target/deps/vtk/bin/python tools/peers/vtk_deform.py --raw target/bench/head.raw --landmarks target/bench/landmarks.txt

The landmarks are a table: a name, from where (x y z) and to where. What is at a point of the output comes from where the spline's
inverse takes it; with --swapped, from where a spline through the swapped landmarks does, which is another map, and needs no
iteration. With --serve one result is made for every line on standard input.
"""

import pathlib

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonTransforms import vtkThinPlateSplineTransform

from reslicing import peer_arguments, report


def arguments():
    arguments = peer_arguments(__doc__, repeats=3)
    arguments.add_argument("--landmarks", required=True, type=pathlib.Path)
    arguments.add_argument("--swapped", action="store_true", help="the spline of the swapped landmarks, not the inverse")
    return arguments.parse_args()


def points(places):
    vtk_points = vtkPoints()
    vtk_points.SetDataTypeToDouble()
    vtk_points.SetData(numpy_to_vtk(np.ascontiguousarray(places), deep=True))
    return vtk_points


def spline(before, after):
    transform = vtkThinPlateSplineTransform()
    transform.SetBasisToR()
    transform.SetSourceLandmarks(points(before))
    transform.SetTargetLandmarks(points(after))
    return transform


def main():
    args = arguments()
    landmarks = np.loadtxt(args.landmarks, usecols=range(1, 7))
    before, after = landmarks[:, :3], landmarks[:, 3:]
    transform = spline(after, before) if args.swapped else spline(before, after).GetInverse()
    report(args, lambda _: transform, {"landmarks": len(landmarks)})


if __name__ == "__main__":
    main()
