# SPDX-License-Identifier: MIT
"""The shipped clip, read once: 640x480, BGR, with its measured camera and hand."""

from types import SimpleNamespace

import pytest

import handyar


@pytest.fixture(scope="session")
def clip():
    folder = {name: handyar.io.data_file("sample/" + name) for name in ("camera.yml", "hand.json")}
    return SimpleNamespace(
        frames=list(handyar.io.open_input("sample"))[:60],
        camera=handyar.io.read_camera(folder["camera.yml"]),
        hand=handyar.io.read_hand(folder["hand.json"]),
    )


@pytest.fixture(scope="session")
def tracked(clip):
    """A tracker that follows the hand, and what it found in each frame."""
    tracker = handyar.Tracker(clip.camera, clip.hand)
    results = [tracker.process(frame.bgr, frame.time_s) for frame in clip.frames]
    assert results[-1].state == "tracking"
    return SimpleNamespace(tracker=tracker, results=results, result=results[-1])
