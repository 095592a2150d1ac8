"""Times vtkImageReslice (linear) on a rotated 256 cubed u8 volume and prints JSON.

    target/deps/vtk/bin/python tools/peers/vtk_reslice.py --raw target/bench/head.raw

The output has the input's lattice; each of its points is looked up after a turn of 30 degrees about (1, 2, 3) through the
volume's centre. Points that fall outside are 0. With --serve one result is made for every line on standard input.
"""

from vtkmodules.vtkCommonTransforms import vtkTransform

from reslicing import peer_arguments, report

ANGLE_DEG = 30.0
AXIS = (1.0, 2.0, 3.0)


def turn_about_centre(image):
    centre = image.GetCenter()
    turn = vtkTransform()
    turn.Translate(*centre)
    turn.RotateWXYZ(ANGLE_DEG, *AXIS)
    turn.Translate(*[-c for c in centre])
    return turn


if __name__ == "__main__":
    report(peer_arguments(__doc__, repeats=7).parse_args(), turn_about_centre, {"angle_deg": ANGLE_DEG, "axis": AXIS})
