"""Times vtkImageReslice (linear) on a 256 cubed u8 volume deformed by a vtkThinPlateSplineTransform and prints JSON.

    target/deps/vtk/bin/python tools/peers/vtk_deform.py --raw target/bench/head.raw --landmarks target/bench/landmarks.txt

The landmarks are a table: a name, from where (x y z) and to where. What is at a point of the output comes from where the spline's
inverse takes it; with --swapped, from where a spline through the swapped landmarks does, which is another map, and needs no
iteration. With --serve one result is made for every line on standard input.
"""

import argparse
import json
import os
import pathlib
import sys

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkPoints, vtkVersion
from vtkmodules.vtkCommonTransforms import vtkThinPlateSplineTransform
from vtkmodules.vtkImagingCore import vtkImageReslice

from timing import measure, serve
from volumes import SIDE, image_from_array


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--raw", required=True, type=pathlib.Path)
    parser.add_argument("--landmarks", required=True, type=pathlib.Path)
    parser.add_argument("--swapped", action="store_true", help="the spline of the swapped landmarks, not the inverse")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--output", type=pathlib.Path, help="where to write a result, raw")
    parser.add_argument("--serve", action="store_true", help="a result for every line on standard input")
    return parser.parse_args()


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
    image = image_from_array(np.fromfile(args.raw, np.uint8).reshape(SIDE, SIDE, SIDE))
    reslice = vtkImageReslice()
    reslice.SetInputData(image)
    reslice.SetResliceTransform(spline(after, before) if args.swapped else spline(before, after).GetInverse())
    reslice.SetInterpolationModeToLinear()
    reslice.SetOutputSpacing(1, 1, 1)
    reslice.SetOutputOrigin(0, 0, 0)
    reslice.SetOutputExtent(0, SIDE - 1, 0, SIDE - 1, 0, SIDE - 1)
    reslice.SetNumberOfThreads(args.threads)

    def run(_):
        reslice.Modified()
        reslice.Update()

    if args.output:
        run(0)
        vtk_to_numpy(reslice.GetOutput().GetPointData().GetScalars()).tofile(args.output)
    about = {"vtk": vtkVersion.GetVTKVersion(), "raw": str(args.raw), "threads": args.threads,
             "landmarks": len(landmarks), "load_average": os.getloadavg()}
    if args.serve:
        serve(about, run)
        return
    json.dump(about | {"reslice": measure(run, args.repeats)}, sys.stdout, indent=1)
    print()


if __name__ == "__main__":
    main()
