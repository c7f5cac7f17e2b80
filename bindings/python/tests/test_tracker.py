# SPDX-License-Identifier: MIT
import pathlib
import threading

import numpy as np
import pytest

import handyar


def test_result_has_the_documented_shapes(tracked):
    r = tracked.result
    assert r.pose.shape == r.raw_pose.shape == (4, 4)
    assert r.covariance.shape == r.raw_covariance.shape == (6, 6)
    assert r.tips.shape == (5, 2) and r.tips_seen.shape == (5,)
    assert r.webs.shape == (4, 2) and r.webs_seen.shape == (4,)
    assert r.velocity_m_s.shape == r.angular_velocity_rad_s.shape == (3,)
    for of_fingers in (r.abduction_rad, r.abduction_sigma_rad, r.flexion_rad, r.flexion_sigma_rad):
        assert of_fingers.shape == (5,)
    assert r.layout in ("thumb_right", "thumb_left") and r.face in ("palm", "back")
    assert not r.camera_assumed and not r.scale_assumed
    assert "tracking" in repr(r)


def test_pose_is_a_rigid_transform_and_covariance_is_one(tracked):
    R = tracked.result.pose[:3, :3]
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-9)
    assert np.linalg.det(R) > 0
    np.testing.assert_array_equal(tracked.result.pose[3], [0, 0, 0, 1])
    np.testing.assert_allclose(tracked.result.covariance, tracked.result.covariance.T)
    assert np.linalg.eigvalsh(tracked.result.covariance).min() > 0
    sigma_m = np.sqrt(np.trace(tracked.result.covariance[3:, 3:]) / 3)
    assert tracked.result.sigma_translation_m == pytest.approx(sigma_m)


def test_fingertips_of_the_hand_model_project_near_those_seen(clip, tracked):
    r = tracked.result
    hand = tracked.tracker.hand.for_layout(r.layout)
    tips_px = clip.camera.project(hand.tips_m @ r.pose[:3, :3].T + r.pose[:3, 3])
    assert np.linalg.norm(tips_px - r.tips, axis=1).mean() < 12


def test_objects_stand_on_fingertips_and_on_the_face_that_is_seen(clip, tracked):
    r = tracked.result
    hand = tracked.tracker.hand.for_layout(r.layout)
    on = {where: handyar.T_hand_attachment(where, hand, r) for where in handyar.ATTACHMENTS}
    for T in on.values():
        np.testing.assert_allclose(T[:3, :3] @ T[:3, :3].T, np.eye(3), atol=1e-9)
    np.testing.assert_allclose(on["face"][:3, 3], hand.palm_centre_m, atol=1e-9)
    np.testing.assert_allclose(on["face"], on[r.face])
    for finger, tip_px in zip(handyar.FINGERS, r.tips, strict=True):
        T_camera_object = r.raw_pose @ on[finger + "_tip"]
        assert np.linalg.norm(clip.camera.project(T_camera_object[:3, 3]) - tip_px) < 6, finger
    with pytest.raises(ValueError, match="elbow"):
        handyar.T_hand_attachment("elbow", hand, r)


def test_without_a_hand_there_is_none_and_nan():
    tracker = handyar.Tracker()
    r = tracker.process(np.zeros((240, 320, 3), np.uint8), 0)
    assert r.state == "searching" and not r.doubtful
    for missing in (r.pose, r.raw_pose, r.covariance, r.velocity_m_s, r.rms_px, r.layout, r.face):
        assert missing is None
    assert r.flexion_rad is None and r.sigma_rotation_rad is None
    assert np.isnan(r.tips).all() and not r.tips_seen.any()
    assert tracker.predict(1) is None
    assert r.camera_assumed and r.scale_assumed
    assert tracker.mask().shape == (240, 320) and not tracker.mask().any()


def test_a_closing_hand_and_a_folded_thumb_are_told():
    tracker = handyar.Tracker()
    clip = pathlib.Path(__file__).parents[3] / "data/gesture/video.mp4"
    results = [tracker.process(frame.bgr, frame.time_s) for frame in handyar.io.open_input(str(clip))]
    events = [r.gesture_event for r in results if r.gesture_event is not None]
    assert events == ["grab", "release", "click"]
    closed = results[60]
    assert closed.gesture == "fist" and "fist" in repr(closed)
    assert closed.pose is None and closed.held_pose.shape == (4, 4)
    assert results[30].gesture == "open" and results[30].held_pose is None


# Every way in which the same picture may lie in memory.
def padded(bgr):
    room = np.full((bgr.shape[0], bgr.shape[1] + 9, 3), 77, np.uint8)
    room[:, : bgr.shape[1]] = bgr
    return room[:, : bgr.shape[1]], "bgr"


def upside_down(bgr):
    return np.ascontiguousarray(bgr[::-1])[::-1], "bgr"


def with_alpha(bgr, format):
    alpha = np.full(bgr.shape[:2] + (1,), 77, np.uint8)
    return np.concatenate([bgr if format == "bgra" else bgr[:, :, ::-1], alpha], axis=2), format


LAYOUTS = {
    "rgb": lambda bgr: (np.ascontiguousarray(bgr[:, :, ::-1]), "rgb"),
    "rgb view of bgr": lambda bgr: (bgr[:, :, ::-1], "rgb"),
    "bgra": lambda bgr: with_alpha(bgr, "bgra"),
    "rgba": lambda bgr: with_alpha(bgr, "rgba"),
    "padded rows": padded,
    "rows upside down": upside_down,
    "read only": lambda bgr: (np.frombuffer(bgr.tobytes(), np.uint8).reshape(bgr.shape), "bgr"),
}


@pytest.mark.parametrize("name", LAYOUTS)
def test_however_a_frame_lies_in_memory_the_result_is_the_same(clip, tracked, name):
    tracker = handyar.Tracker(clip.camera, clip.hand)
    for frame, expected in zip(clip.frames[:20], tracked.results):
        picture, format = LAYOUTS[name](frame.bgr)
        result = tracker.process(picture, frame.time_s, format)
        np.testing.assert_array_equal(result.tips, expected.tips)
    assert result.state == "tracking"
    np.testing.assert_array_equal(result.pose, expected.pose)


PICTURE = np.zeros((240, 320, 3), np.uint8)


@pytest.mark.parametrize(
    "frame, format, fault, says",
    [
        (None, "bgr", TypeError, "numpy array is wanted, not NoneType"),
        ([[1, 2, 3]], "bgr", TypeError, "not list"),
        (PICTURE.astype(float), "bgr", TypeError, "uint8 are wanted, not float64"),
        (PICTURE[:, :, 0], "bgr", ValueError, "grey image"),
        (PICTURE[:, :, :1], "bgr", ValueError, "grey image"),
        (PICTURE[:, :, :2], "bgr", ValueError, r"\(240, 320, 2\) is not \(height, width, 3\)"),
        (PICTURE, "rgba", ValueError, r"\(height, width, 4\) for format 'rgba'"),
        (PICTURE, "BGR", ValueError, "not 'BGR'"),
        (PICTURE[:, ::-1], "bgr", ValueError, "ascontiguousarray"),
        (PICTURE[:, ::2], "bgr", ValueError, "ascontiguousarray"),
        (PICTURE.transpose(1, 0, 2), "bgr", ValueError, "ascontiguousarray"),
        (np.broadcast_to(PICTURE[:1], PICTURE.shape), "bgr", ValueError, "rows overlap"),
        (PICTURE[:100], "bgr", ValueError, "320x100 pixels: unsupported image size"),
        (PICTURE[:0], "bgr", ValueError, ""),
    ],
)
def test_frames_that_cannot_be_read_are_refused_clearly(frame, format, fault, says):
    tracker = handyar.Tracker(
        handyar.Camera.from_field_of_view(320, 240), handyar.average_adult_hand()
    )
    with pytest.raises(fault, match=says):
        tracker.process(frame, 0, format)
    tracker.process(PICTURE, 0)  # as it was: time 0 is still to come


@pytest.mark.parametrize("time_s", [1.0, 0.5, float("nan"), float("inf")])
def test_time_must_increase(time_s):
    tracker = handyar.Tracker(
        handyar.Camera.from_field_of_view(320, 240), handyar.average_adult_hand()
    )
    tracker.process(PICTURE, 1.0)
    with pytest.raises(ValueError, match="not after the previous"):
        tracker.process(PICTURE, time_s)
    tracker.reset()
    tracker.process(PICTURE, 0.5)


def test_prediction_goes_on_from_the_pose(tracked):
    r = tracked.result
    now = tracked.tracker.predict(r.time_s)
    later = tracked.tracker.predict(r.time_s + 0.05)
    np.testing.assert_allclose(now.pose, r.pose, atol=1e-9)
    np.testing.assert_allclose(
        later.pose[:3, 3], r.pose[:3, 3] + 0.05 * r.velocity_m_s, atol=1e-6
    )
    assert np.trace(later.covariance) > np.trace(now.covariance)
    assert tracked.tracker.predict(r.time_s + 10) is None


def test_mask_covers_the_hand(tracked):
    mask = tracked.tracker.mask()
    assert mask.shape == (480, 640) and set(np.unique(mask)) == {0, 255}
    tip, web = tracked.result.tips[2], tracked.result.webs[1:3].mean(axis=0)
    x, y = (web + 0.3 * (web - tip)).astype(int)  # below the middle finger
    assert mask[y, x] == 255
    assert mask[2, 2] == 0 and 0.02 < (mask > 0).mean() < 0.5


def test_the_side_tells_the_face(clip):
    faces = {}
    for side in ("left", "right"):
        tracker = handyar.Tracker(clip.camera, clip.hand, side=side)
        for frame in clip.frames[:20]:
            result = tracker.process(frame.bgr, frame.time_s)
        faces[side] = result.face
    assert set(faces.values()) == {"palm", "back"}
    with pytest.raises(ValueError, match="'left', 'right' or None"):
        handyar.Tracker(clip.camera, clip.hand, side="both")


def test_a_filter_that_is_off_passes_the_raw_pose_through(clip):
    tracker = handyar.Tracker(clip.camera, clip.hand, smoothing=0)
    for frame in clip.frames[:20]:
        result = tracker.process(frame.bgr, frame.time_s)
    np.testing.assert_allclose(result.pose, result.raw_pose, atol=1e-9)


def test_threads_share_a_tracker_without_a_deadlock(clip):
    shared = handyar.Tracker(clip.camera, clip.hand)
    poses = [[], []]

    def follow(own):
        tracker = handyar.Tracker(clip.camera, clip.hand)
        for frame in clip.frames[:20]:
            own.append(tracker.process(frame.bgr, frame.time_s).pose)
            shared.mask()
            shared.predict(0)
            handyar.draw.outline(frame.bgr.copy(), shared)
            try:
                shared.process(frame.bgr, frame.time_s)
            except ValueError:  # the other thread was first
                pass

    threads = [threading.Thread(target=follow, args=(own,)) for own in poses]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    np.testing.assert_array_equal(poses[0][-1], poses[1][-1])


def test_trackers_that_share_a_view_leave_one_hand_to_one_of_them(clip):
    first, second = handyar.Tracker(clip.camera), handyar.Tracker(clip.camera)
    first.share_view(second)
    states = [
        tuple(t.process(frame.bgr, frame.time_s).state for t in (first, second))
        for frame in clip.frames[:20]
    ]
    assert states[-1][0] == "tracking"
    assert all(state == "searching" for _, state in states)
    with pytest.raises(ValueError, match="two trackers"):
        first.share_view(first)


def test_two_threads_may_pair_the_same_trackers_either_way_round():
    trackers = handyar.Tracker(), handyar.Tracker()

    def pair(first, second):
        for _ in range(300_000):
            first.share_view(second)

    threads = [
        threading.Thread(target=pair, args=pair_of, daemon=True) for pair_of in (trackers, trackers[::-1])
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60)
        assert not thread.is_alive(), "each waits for the other"
