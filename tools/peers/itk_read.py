"""Reads a volume file with SimpleITK, whenever it is asked to.

    target/deps/vtk/bin/python tools/peers/itk_read.py --path head.nii.gz --serve
"""

import argparse

import SimpleITK as sitk

import timing


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--path", required=True)
    parser.add_argument("--serve", action="store_true", required=True)
    arguments = parser.parse_args()
    image = sitk.ReadImage(arguments.path)
    timing.serve({"voxels": image.GetNumberOfPixels()}, lambda _: sitk.ReadImage(arguments.path))


main()
