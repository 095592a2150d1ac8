"""Times the extraction of a surface by another program, and prints JSON.

    target/deps/vtk/bin/python tools/peers/vtk_surface.py --raw target/bench/ball-256.f32 --side 256 --iso 0.5 --method flying-edges

Normals are computed; scalars and gradients are not kept. With --serve one surface is made for every line on standard input.
"""

import argparse
import json
import os
import pathlib
import sys

import numpy as np
from vtkmodules.vtkCommonCore import vtkSMPTools, vtkVersion
from vtkmodules.vtkFiltersCore import vtkFlyingEdges3D, vtkMarchingCubes

from timing import measure, serve
from volumes import image_from_array

TYPES = {".u8": np.uint8, ".f32": np.float32}
METHODS = {"flying-edges": vtkFlyingEdges3D, "marching-cubes": vtkMarchingCubes}


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--raw", required=True, type=pathlib.Path, help="voxels, the suffix says their type")
    parser.add_argument("--side", required=True, type=int)
    parser.add_argument("--iso", required=True, type=float)
    parser.add_argument("--method", required=True, choices=METHODS)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--serve", action="store_true", help="a surface for every line on standard input")
    return parser.parse_args()


def main():
    args = arguments()
    vtkSMPTools.SetBackend("STDThread")
    vtkSMPTools.Initialize(args.threads)
    voxels = np.fromfile(args.raw, TYPES[args.raw.suffix])
    method = METHODS[args.method]()
    method.SetInputData(image_from_array(voxels.reshape(args.side, args.side, args.side)))
    method.SetValue(0, args.iso)
    method.ComputeNormalsOn()
    method.ComputeGradientsOff()
    method.ComputeScalarsOff()

    def run(_):
        method.Modified()
        method.Update()

    run(0)
    about = {"vtk": vtkVersion.GetVTKVersion(), "raw": str(args.raw), "threads": vtkSMPTools.GetEstimatedNumberOfThreads(),
             "triangles": method.GetOutput().GetNumberOfCells(), "points": method.GetOutput().GetNumberOfPoints(),
             "load_average": os.getloadavg()}
    if args.serve:
        serve(about, run)
        return
    json.dump(about | {args.method: measure(run, args.repeats)}, sys.stdout, indent=1)
    print()


if __name__ == "__main__":
    main()
