"""Times vtkImageReslice (linear) on a rotated 256 cubed u8 volume and prints JSON.

    target/deps/vtk/bin/python tools/peers/vtk_reslice.py --raw target/bench/head.raw

The output has the input's lattice; each of its points is looked up after a turn of 30 degrees about (1, 2, 3) through the
volume's centre. Points that fall outside are 0. With --serve one result is made for every line on standard input.
"""

import argparse
import json
import os
import pathlib
import sys

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkVersion
from vtkmodules.vtkCommonTransforms import vtkTransform
from vtkmodules.vtkImagingCore import vtkImageReslice

from timing import measure, serve
from volumes import SIDE, image_from_array

ANGLE_DEG = 30.0
AXIS = (1.0, 2.0, 3.0)


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--raw", required=True, type=pathlib.Path)
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--output", type=pathlib.Path, help="where to write a result, raw")
    parser.add_argument("--serve", action="store_true", help="a result for every line on standard input")
    return parser.parse_args()


def turn_about(centre):
    turn = vtkTransform()
    turn.Translate(*centre)
    turn.RotateWXYZ(ANGLE_DEG, *AXIS)
    turn.Translate(*[-c for c in centre])
    return turn


def main():
    args = arguments()
    image = image_from_array(np.fromfile(args.raw, np.uint8).reshape(SIDE, SIDE, SIDE))
    reslice = vtkImageReslice()
    reslice.SetInputData(image)
    reslice.SetResliceTransform(turn_about(image.GetCenter()))
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
    about = {"vtk": vtkVersion.GetVTKVersion(), "raw": str(args.raw), "threads": args.threads, "angle_deg": ANGLE_DEG,
             "axis": AXIS, "load_average": os.getloadavg()}
    if args.serve:
        serve(about, run)
        return
    json.dump(about | {"reslice": measure(run, args.repeats)}, sys.stdout, indent=1)
    print()


if __name__ == "__main__":
    main()
