# SPDX-License-Identifier: MIT
"""handyar.io, handyar.draw and handyar.calibration, and the program."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import handyar


def test_frames_stay_as_they_are_while_others_are_read(clip):
    source = handyar.io.open_input("sample")
    assert (source.width_px, source.height_px, source.live) == (640, 480, False)
    first = next(source)
    before = first.bgr.copy()
    second = next(source)
    assert (first.bgr == before).all() and (second.bgr != before).any()
    assert (first.index, second.index, first.time_s) == (0, 1, 0) and second.time_s > 0


@pytest.mark.parametrize("read", ["read_camera", "read_hand", "read_poses", "open_input"])
def test_faults_name_the_file(tmp_path, read):
    with pytest.raises(handyar.io.Error, match="missing.file"):
        getattr(handyar.io, read)(tmp_path / "missing.file")


def test_files_whose_names_are_no_text_are_named_too(clip, tmp_path):
    path = os.fsencode(tmp_path) + b"/\xff.png"
    with pytest.raises(handyar.io.Error, match="\udcff.png: no such file"):
        handyar.io.open_input(path)
    shutil.copy(Path(handyar.io.data_file("sample/camera.yml")), path)
    with pytest.raises(handyar.io.Error, match="\udcff.png: is not a picture"):
        handyar.io.open_input(path)


def test_camera_and_hand_files_hold_what_was_written(clip, tmp_path):
    handyar.io.write_camera(tmp_path / "camera.yml", clip.camera)
    handyar.io.write_hand(tmp_path / "hand.json", clip.hand)
    camera = handyar.io.read_camera(tmp_path / "camera.yml")
    np.testing.assert_allclose(camera.matrix, clip.camera.matrix)
    np.testing.assert_allclose(
        handyar.io.read_hand(tmp_path / "hand.json").tips_m, clip.hand.tips_m, atol=1e-9
    )


def test_pose_files_hold_the_results(clip, tracked, tmp_path):
    path = tmp_path / "poses.csv"
    with handyar.io.PoseWriter(path) as writer:
        for frame, result in zip(clip.frames, tracked.results):
            writer.write(frame.index, result)
    poses = handyar.io.read_poses(path)
    assert len(poses.frame) == len(clip.frames) and poses.pose.shape == (len(clip.frames), 4, 4)
    assert list(poses.state) == [r.state for r in tracked.results]
    assert list(poses.face) == [r.face or "" for r in tracked.results]
    assert (poses.hand == 1).all()
    for i, r in enumerate(tracked.results):
        assert np.isnan(poses.pose[i]).all() == (r.pose is None)
    np.testing.assert_allclose(poses.pose[-1], tracked.result.pose, atol=1e-6)
    np.testing.assert_allclose(poses.raw_pose[-1], tracked.result.raw_pose, atol=1e-6)
    np.testing.assert_allclose(poses.tips[-1], tracked.result.tips, atol=1e-3)
    assert poses.sigma_rotation_rad[-1] == pytest.approx(tracked.result.sigma_rotation_rad, abs=1e-8)


def test_pose_files_of_two_hands_tell_which_row_is_whose(tmp_path):
    path = tmp_path / "poses.csv"
    clip = Path(__file__).parents[3] / "data/gesture/video.mp4"
    assert run("track", str(clip), "--hands", "2", "--poses", str(path)).returncode == 0
    poses = handyar.io.read_poses(path)
    assert list(poses.frame[:4]) == [0, 0, 1, 1] and list(poses.hand[:4]) == [1, 2, 1, 2]
    tracked = poses.state == "tracking"
    assert tracked[poses.hand == 1].sum() > 50 and not tracked[poses.hand == 2].any()


def test_an_exception_leaves_no_pose_file(tracked, tmp_path):
    path = tmp_path / "poses.csv"
    with pytest.raises(KeyError):
        with handyar.io.PoseWriter(path) as writer:
            writer.write(0, tracked.result)
            raise KeyError
    assert not list(tmp_path.iterdir())
    with pytest.raises(ValueError, match="finished"):
        writer.write(1, tracked.result)


def test_what_is_no_pose_file_is_told(tmp_path):
    path = tmp_path / "poses.csv"
    for text in ("a,b\n1,2\n", ""):
        path.write_text(text)
        with pytest.raises(handyar.io.Error, match="poses.csv: not a pose file"):
            handyar.io.read_poses(path)


def test_drawing_marks_the_picture_where_the_hand_is(clip, tracked):
    bgr = clip.frames[-1].bgr

    def changed(draw):
        picture = bgr.copy()
        draw(picture)
        return (picture != bgr).any(axis=2)

    tips = changed(lambda p: handyar.draw.tips(p, tracked.result))
    axes = changed(lambda p: handyar.draw.axes(p, clip.camera, tracked.result.pose))
    outline = changed(lambda p: handyar.draw.outline(p, tracked.tracker))
    everything = changed(lambda p: handyar.draw.annotate(p, tracked.tracker, tracked.result))
    for x, y in tracked.result.tips.round().astype(int):
        assert tips[y, x]
    x, y = clip.camera.project(tracked.result.pose[:3, 3]).round().astype(int)
    assert axes[y, x] and not tips[y, x]
    near_edge = np.abs(np.diff(tracked.tracker.mask().astype(int), axis=1)) > 0
    assert outline[:, 1:][near_edge].mean() > 0.9
    assert everything.sum() > max(tips.sum(), axes.sum(), outline.sum())


def test_drawing_on_rgb_gives_the_same_picture(clip, tracked):
    bgr = clip.frames[-1].bgr.copy()
    rgb = np.ascontiguousarray(bgr[:, :, ::-1])
    handyar.draw.annotate(bgr, tracked.tracker, tracked.result)
    handyar.draw.annotate(rgb, tracked.tracker, tracked.result, format="rgb")
    np.testing.assert_array_equal(rgb[:, :, ::-1], bgr)


def test_pictures_that_cannot_be_drawn_on_are_refused(clip, tracked):
    locked = clip.frames[-1].bgr.copy()
    locked.flags.writeable = False
    with pytest.raises(ValueError, match="cannot be written on"):
        handyar.draw.tips(locked, tracked.result)
    with pytest.raises(ValueError, match="upside down"):
        handyar.draw.tips(clip.frames[-1].bgr.copy()[::-1], tracked.result)
    with pytest.raises(ValueError, match="'bgr' or 'rgb'"):
        handyar.draw.tips(locked, tracked.result, format="rgba")


def test_calibration_measures_the_shipped_recording():
    folder = Path(handyar.io.data_file("sample/camera.yml")).parents[1] / "calibrate"
    source = handyar.io.open_input(folder / "video.mp4")
    tracker = handyar.Tracker(
        handyar.Camera.from_field_of_view(source.width_px, source.height_px),
        handyar.average_adult_hand(),
    )
    session = handyar.calibration.Session(
        handyar.calibration.Board(8, 6, 0.022), source.width_px, source.height_px
    )
    assert session.advice == ""
    seen = sum(
        session.add(frame.bgr, tracker.process(frame.bgr, frame.time_s), tracker.hand)
        for frame in source
    )
    assert seen > 20 and session.views > 5 and session.advice
    found = session.camera()
    truth = handyar.io.read_camera(folder / "camera.yml")
    assert found.camera.matrix[0, 0] == pytest.approx(truth.matrix[0, 0], rel=0.02)
    hand = session.hand(found.camera).hand
    assert hand.source == "checkerboard" and not hand.scale_assumed
    assert hand.span_m == pytest.approx(handyar.io.read_hand(folder / "hand.json").span_m, rel=0.03)


def test_calibration_says_what_is_missing(clip):
    session = handyar.calibration.Session(handyar.calibration.Board(8, 6, 0.025), 640, 480)
    with pytest.raises(handyar.calibration.CalibrationError):
        session.camera()
    tracker = handyar.Tracker(clip.camera, clip.hand)
    half = np.zeros((240, 320, 3), np.uint8)
    with pytest.raises(handyar.calibration.CalibrationError, match="320x240"):
        session.add(half, handyar.Tracker().process(half, 0.0), tracker.hand)
    with pytest.raises(handyar.calibration.CalibrationError):
        handyar.calibration.SelfSession().hand(clip.camera)
    with pytest.raises(ValueError, match="one of them"):
        handyar.calibration.SelfSession().hand(clip.camera, span_m=0.19, hand_length_m=0.19)
    with pytest.raises(ValueError, match="inner corners"):
        handyar.calibration.Board(2, 6, 0.025)
    assert handyar.calibration.Board(8, 6, 0.025).pdf().startswith(b"%PDF")


def run(*arguments, **options):
    return subprocess.run(
        [sys.executable, "-m", "handyar", *arguments], capture_output=True, text=True, **options
    )


def test_the_module_is_the_program(clip, tracked, tmp_path):
    path = tmp_path / "poses.csv"
    camera, hand = (handyar.io.data_file("sample/" + name) for name in ("camera.yml", "hand.json"))
    done = run("track", "sample", "--camera", camera, "--hand", hand, "--poses", str(path))
    assert done.returncode == 0, done.stderr
    poses = handyar.io.read_poses(path)
    np.testing.assert_allclose(poses.pose[len(clip.frames) - 1], tracked.result.pose, atol=1e-6)
    assert run("track", "--nonsense").returncode == 2


def test_the_program_of_the_same_build_is_found_and_a_missing_one_told(tmp_path):
    nowhere = {**os.environ, "PATH": ""}
    assert run("--version", env=nowhere).returncode == 0
    shutil.copytree(Path(handyar.__file__).parent, tmp_path / "handyar")
    done = run("--version", env={**nowhere, "PYTHONPATH": str(tmp_path)}, cwd=tmp_path)
    assert done.returncode == 1 and "not installed" in done.stderr
    assert len(done.stderr.splitlines()) == 1
