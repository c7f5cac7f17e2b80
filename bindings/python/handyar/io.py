# SPDX-License-Identifier: MIT
"""Frames from videos and cameras; camera, hand and pose files."""

import csv
import os
from dataclasses import dataclass
from typing import Any, Sequence, Union

import numpy as np
from numpy.typing import NDArray

from ._core import FINGERS
from ._io import (
    CameraInfo,
    Error,
    Frame,
    FrameSource,
    PoseWriter,
    data_file,
    list_cameras,
    open_input,
    read_camera,
    read_hand,
    write_camera,
    write_hand,
)

__all__ = [
    "CameraInfo",
    "Error",
    "Frame",
    "FrameSource",
    "PoseWriter",
    "Poses",
    "data_file",
    "list_cameras",
    "open_input",
    "read_camera",
    "read_hand",
    "read_poses",
    "write_camera",
    "write_hand",
]


@dataclass
class Poses:
    """A pose file: what TrackResult calls the same, n frames long; nan where there is nothing."""

    frame: NDArray[np.int64]
    """Numbers of the frames, shape (n,)."""
    time_s: NDArray[np.float64]
    """Seconds since the first frame, shape (n,)."""
    state: NDArray[np.str_]
    """'searching', 'acquiring', 'tracking' or 'lost', shape (n,)."""
    layout: NDArray[np.str_]
    """'thumb_right', 'thumb_left' or '', shape (n,)."""
    face: NDArray[np.str_]
    """'palm', 'back' or '', shape (n,)."""
    hand: NDArray[np.int64]
    """1; of two hands 1 or 2, and each frame has a row of either, shape (n,)."""
    doubtful: NDArray[np.bool_]
    """Whether the pose is not to be relied on, shape (n,)."""
    tips: NDArray[np.float64]
    """Fingertips, shape (n, 5, 2), pixels."""
    pose: NDArray[np.float64]
    """T_camera_hand, filtered, shape (n, 4, 4), metres."""
    raw_pose: NDArray[np.float64]
    """T_camera_hand of each frame alone, shape (n, 4, 4), metres."""
    rms_px: NDArray[np.float64]
    """Distance of the hand in its pose from what was seen, shape (n,), pixels."""
    sigma_rotation_rad: NDArray[np.float64]
    """Standard deviation of the rotation, shape (n,), radians."""
    sigma_translation_m: NDArray[np.float64]
    """Standard deviation of the translation, shape (n,), metres."""


def read_poses(path: Union[str, "os.PathLike[str]"]) -> Poses:
    """Reads a pose file (CSV), of `handyar track --poses` or PoseWriter. Raises Error."""
    try:
        with open(path, newline="", encoding="utf-8") as file:
            reader = csv.DictReader(file)
            header = reader.fieldnames or ()
            rows = list(reader)
    except (OSError, UnicodeDecodeError, csv.Error) as fault:
        raise Error(f"{os.fspath(path)}: cannot be read: {fault}") from fault

    def texts(column: str) -> Any:
        if column not in header:
            raise Error(f"{os.fspath(path)}: not a pose file: there is no column {column}")
        return np.array([row[column] or "" for row in rows], dtype=np.str_)

    def numbers(*columns: str) -> Any:
        try:
            values = [[float(text or "nan") for text in texts(column)] for column in columns]
        except ValueError as fault:
            raise Error(f"{os.fspath(path)}: {fault}") from fault
        return np.array(values).T

    def transforms(prefix: str) -> NDArray[np.float64]:
        quaternion = numbers(*(prefix + name for name in ("qw", "qx", "qy", "qz")))
        translation_m = numbers(*(prefix + name for name in ("tx_m", "ty_m", "tz_m")))
        return _transforms(quaternion, translation_m)

    return Poses(
        frame=numbers("frame")[:, 0].astype(np.int64),
        time_s=numbers("time_s")[:, 0],
        state=texts("state"),
        layout=texts("layout"),
        face=texts("face"),
        hand=numbers("hand")[:, 0].astype(np.int64),
        doubtful=numbers("doubtful")[:, 0] == 1,
        tips=numbers(*(f"{finger}_{axis}" for finger in FINGERS for axis in "xy")).reshape(-1, 5, 2),
        pose=transforms(""),
        raw_pose=transforms("raw_"),
        rms_px=numbers("rms_px")[:, 0],
        sigma_rotation_rad=numbers("sigma_rotation_rad")[:, 0],
        sigma_translation_m=numbers("sigma_translation_m")[:, 0],
    )


def _transforms(
    quaternion: NDArray[np.float64], translation_m: NDArray[np.float64]
) -> NDArray[np.float64]:
    w, x, y, z = quaternion.T
    tx, ty, tz = translation_m.T
    zero = 0 * w  # nan where there is no pose
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y), tx],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x), ty],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y), tz],
        [zero, zero, zero, zero + 1],
    ]
    return np.moveaxis(np.array(rows), -1, 0)
