# SPDX-License-Identifier: MIT
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._core import Camera, Tracker, TrackResult

_Picture = NDArray[np.uint8]
_Format = Literal["bgr", "rgb"]

def annotate(
    picture: _Picture,
    tracker: Tracker,
    result: TrackResult,
    format: _Format = "bgr",
    mirrored: bool = False,
) -> None: ...
def outline(picture: _Picture, tracker: Tracker, format: _Format = "bgr") -> None: ...
def tips(picture: _Picture, result: TrackResult, format: _Format = "bgr") -> None: ...
def axes(
    picture: _Picture, camera: Camera, pose: ArrayLike, format: _Format = "bgr"
) -> None: ...
