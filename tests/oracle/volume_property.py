"""What VTK's functions are that 3D Slicer makes of a .vp.json file.

A request is a line of JSON: file, and at, a list of values. The answer is a line of JSON: the colours and the opacities there.
"""

import json
import sys

import vtk


def functions(component):
    color = vtk.vtkColorTransferFunction()
    for p in component["rgbTransferFunction"]["points"]:
        color.AddRGBPoint(p["x"], *p["color"], p["midpoint"], p["sharpness"])
    opacity = vtk.vtkPiecewiseFunction()
    for p in component["scalarOpacity"]["points"]:
        opacity.AddPoint(p["x"], p["y"], p["midpoint"], p["sharpness"])
    return color, opacity


def main():
    while line := sys.stdin.buffer.readline():
        request = json.loads(line)
        with open(request["file"]) as file:
            component = json.load(file)["volumeProperties"][0]["components"][0]
        color, opacity = functions(component)
        answer = {
            "color": [color.GetColor(x) for x in request["at"]],
            "opacity": [opacity.GetValue(x) for x in request["at"]],
        }
        print(json.dumps(answer), flush=True)


if __name__ == "__main__":
    main()
