"""Reads a volume file, or the DICOM series in a folder, with SimpleITK, whenever it is asked to.

    target/deps/vtk/bin/python tools/peers/itk_read.py --path head.nii.gz --serve
"""

import argparse
import os

import SimpleITK as sitk

import timing


def read(path):
    return sitk.ReadImage(sitk.ImageSeriesReader.GetGDCMSeriesFileNames(path) if os.path.isdir(path) else path)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--path", required=True)
    parser.add_argument("--serve", action="store_true", required=True)
    arguments = parser.parse_args()
    image = read(arguments.path)
    timing.serve({"voxels": image.GetNumberOfPixels()}, lambda _: read(arguments.path))


main()
