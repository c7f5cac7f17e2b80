# SPDX-License-Identifier: MIT
"""A bare outstretched hand, used like a printed AR marker.

    import handyar
    camera = handyar.Camera.from_field_of_view(640, 480)  # or handyar.io.read_camera("camera.yml")
    tracker = handyar.Tracker(camera, handyar.average_adult_hand())
    result = tracker.process(frame, time_s)  # frame: numpy, uint8, (480, 640, 3), BGR
    if result.pose is not None:
        print(result.pose[:3, 3])  # where the hand is, metres, in the camera frame

Everything is in metres, seconds, radians and pixels; the centre of the top-left pixel is (0, 0).
Camera frame: x right, y down, z forward. Arrays of points have one point a row. `pose` is
T_camera_hand, 4x4: it takes points of the hand frame to the camera frame.

handyar.io           frames from videos and cameras; camera, hand and pose files
handyar.draw         what was found, drawn on a picture
handyar.calibration  camera and hand measured, with a checkerboard or without
"""

import importlib
from types import ModuleType
from typing import TYPE_CHECKING

from ._core import (
    ATTACHMENTS,
    FINGERS,
    Camera,
    FilteredPose,
    HandModel,
    PlanarPose,
    PoseFilter,
    PoseFilterConfig,
    T_hand_attachment,
    Tracker,
    TrackResult,
    average_adult_hand,
    solve_planar,
)

if TYPE_CHECKING:
    from . import calibration, draw, io

__all__ = [
    "ATTACHMENTS",
    "FINGERS",
    "Camera",
    "FilteredPose",
    "HandModel",
    "PlanarPose",
    "PoseFilter",
    "PoseFilterConfig",
    "T_hand_attachment",
    "TrackResult",
    "Tracker",
    "average_adult_hand",
    "calibration",
    "draw",
    "io",
    "solve_planar",
]


# These bring OpenCV's libraries along, so they are loaded when they are first named.
def __getattr__(name: str) -> ModuleType:
    if name in ("calibration", "draw", "io"):
        return importlib.import_module("." + name, __name__)
    raise AttributeError(f"module 'handyar' has no attribute {name!r}")
