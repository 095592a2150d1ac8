"""What measurements of vtkImageReslice share: a 256 cubed u8 volume resampled (linear) on its own lattice by some transform."""

import argparse
import json
import os
import pathlib
import sys

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkVersion
from vtkmodules.vtkImagingCore import vtkImageReslice

from timing import measure, serve
from volumes import SIDE, image_from_array


def peer_arguments(description, repeats):
    """The arguments of every measurement; a script adds its own."""
    parser = argparse.ArgumentParser(description=description.splitlines()[0])
    parser.add_argument("--raw", required=True, type=pathlib.Path)
    parser.add_argument("--repeats", type=int, default=repeats)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--output", type=pathlib.Path, help="where to write a result, raw")
    parser.add_argument("--serve", action="store_true", help="a result for every line on standard input")
    return parser


def reslice_on_own_lattice(image, transform, threads):
    reslice = vtkImageReslice()
    reslice.SetInputData(image)
    reslice.SetResliceTransform(transform)
    reslice.SetInterpolationModeToLinear()
    reslice.SetOutputSpacing(1, 1, 1)
    reslice.SetOutputOrigin(0, 0, 0)
    reslice.SetOutputExtent(0, SIDE - 1, 0, SIDE - 1, 0, SIDE - 1)
    reslice.SetNumberOfThreads(threads)
    return reslice


def report(args, transform_for, own):
    """Prints times of the transform that `transform_for` makes for the image, with the script's `own` facts."""
    image = image_from_array(np.fromfile(args.raw, np.uint8).reshape(SIDE, SIDE, SIDE))
    reslice = reslice_on_own_lattice(image, transform_for(image), args.threads)

    def run(_):
        reslice.Modified()
        reslice.Update()

    if args.output:
        run(0)
        vtk_to_numpy(reslice.GetOutput().GetPointData().GetScalars()).tofile(args.output)
    about = {"vtk": vtkVersion.GetVTKVersion(), "raw": str(args.raw), "threads": args.threads} | own
    about["load_average"] = os.getloadavg()
    if args.serve:
        serve(about, run)
        return
    json.dump(about | {"reslice": measure(run, args.repeats)}, sys.stdout, indent=1)
    print()
