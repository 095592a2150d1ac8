"""Reads DICOM with SimpleITK: each line on stdin is a file's path, or a folder's whose one series is meant; the answer is a line of
JSON (size, spacing, origin, direction, components; of a folder the last file's ImagePositionPatient) and the values as float64, x fastest."""
import json
import os
import sys

import SimpleITK as sitk

sitk.ProcessObject.SetGlobalWarningDisplay(False)
for line in sys.stdin:
    path = json.loads(line)
    last = None
    if os.path.isdir(path):
        path = sitk.ImageSeriesReader.GetGDCMSeriesFileNames(path)
        header = sitk.ImageFileReader()
        header.SetFileName(path[-1])
        header.ReadImageInformation()
        last = header.GetMetaData("0020|0032")
    try:
        image = sitk.ReadImage(path)
        if image.GetDimension() == 2:
            image = sitk.JoinSeries(image)
        values = sitk.GetArrayFromImage(image).astype("<f8").tobytes()
        answer = {
            "size": image.GetSize(),
            "spacing": image.GetSpacing(),
            "origin": image.GetOrigin(),
            "direction": image.GetDirection(),
            "last": last,
            "components": image.GetNumberOfComponentsPerPixel(),
        }
    except RuntimeError as error:
        answer, values = {"refused": str(error)}, b""
    sys.stdout.buffer.write(json.dumps(answer).encode() + b"\n" + values)
    sys.stdout.buffer.flush()
