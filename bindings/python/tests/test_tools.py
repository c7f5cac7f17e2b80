# SPDX-License-Identifier: MIT
"""Camera, planar pose and pose filter, which stand alone."""

import numpy as np
import pytest

import handyar


def test_camera_projects_as_a_pinhole_and_back():
    camera = handyar.Camera(640, 480, fx_px=600, fy_px=610, cx_px=320, cy_px=240)
    np.testing.assert_allclose(camera.project([0.1, -0.2, 0.5]), [440, -4])
    np.testing.assert_array_equal(camera.matrix, [[600, 0, 320], [0, 610, 240], [0, 0, 1]])
    lens = handyar.Camera(
        640, 480, fx_px=600, fy_px=610, cx_px=320, cy_px=240, distortion=[-0.2, 0.05, 0.001, 0, 0]
    )
    points = np.random.default_rng(1).uniform([-0.2, -0.1, 0.4], [0.2, 0.1, 0.6], (3, 4, 3))
    rays = lens.unproject(lens.project(points))
    assert rays.shape == (3, 4, 2)
    np.testing.assert_allclose(rays, points[..., :2] / points[..., 2:], atol=1e-8)
    assert abs(lens.project(points) - camera.project(points)).max() > 1


@pytest.mark.parametrize(
    "size",
    [
        dict(width_px=0), dict(fx_px=-1), dict(fy_px=np.nan), dict(fx_px=np.inf), dict(cx_px=np.nan),
        dict(readout_s=20), dict(readout_s=-0.01), dict(readout_s=np.nan),
    ],
)
def test_cameras_that_cannot_be_are_refused(size):
    arguments = dict(width_px=640, height_px=480, fx_px=600, fy_px=600, cx_px=320, cy_px=240)
    with pytest.raises(ValueError):
        handyar.Camera(**{**arguments, **size})


@pytest.mark.parametrize("size", [(0, 480), (640, -1)])
def test_cameras_without_pictures_are_refused(size):
    with pytest.raises(ValueError, match="size of a picture"):
        handyar.Camera.from_field_of_view(*size)
    with pytest.raises(ValueError, match="size of a picture"):
        handyar.Camera.from_field_of_view(640, 480).scaled_to(*size)


@pytest.mark.parametrize("fov_rad", [0, np.pi, -1, np.nan])
def test_fields_of_view_that_cannot_be_are_refused(fov_rad):
    with pytest.raises(ValueError, match="between 0 and pi"):
        handyar.Camera.from_field_of_view(640, 480, fov_rad)


def test_planar_pose_is_found_again():
    a = np.deg2rad(30)
    pose = np.eye(4)
    pose[:3, :3] = [[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]]
    pose[:3, 3] = [0.02, -0.03, 0.4]
    plane_m = np.array([[-0.05, -0.04], [0.05, -0.04], [0.05, 0.04], [-0.05, 0.04]])
    in_camera = np.c_[plane_m, np.zeros(4)] @ pose[:3, :3].T + pose[:3, 3]
    better, other = handyar.solve_planar(plane_m, in_camera[:, :2] / in_camera[:, 2:])
    np.testing.assert_allclose(better.pose, pose, atol=1e-6)
    assert better.rms < 1e-6 < other.rms
    assert handyar.solve_planar(plane_m[:3], plane_m[:3]) is None
    with pytest.raises(ValueError, match="one image of each"):
        handyar.solve_planar(plane_m, plane_m[:3])
    with pytest.raises(ValueError, match=r"plane_m: an array of shape \(n, 2\)"):
        handyar.solve_planar(in_camera, plane_m)


def test_a_filter_is_not_configured_with_what_is_no_number():
    for name in ("acceleration_m_s2", "acceleration_rad_s2", "gate_probability", "max_coast_s"):
        with pytest.raises(ValueError, match="numbers"):
            handyar.PoseFilterConfig(**{name: np.nan})


def test_filter_foretells_a_steady_motion_and_refuses_what_is_no_pose():
    filter = handyar.PoseFilter(handyar.PoseFilterConfig(max_coast_s=0.5))
    assert filter.predict(0) is None
    pose = np.eye(4)
    for i in range(60):
        pose[:3, 3] = [0.3 * i / 30, 0, 0.5]
        assert filter.update(i / 30, pose, np.eye(6) * 1e-6)
    ahead = filter.predict(59 / 30 + 0.1)
    np.testing.assert_allclose(ahead.velocity_m_s, [0.3, 0, 0], atol=0.01)
    np.testing.assert_allclose(ahead.pose[0, 3], 0.3 * (59 / 30 + 0.1), atol=0.003)
    assert not filter.update(1.0, pose, np.eye(6) * 1e-6), "time that does not increase"
    assert filter.predict(59 / 30 + 0.6) is None
    for bad in (2 * pose, np.diag([1.0, 1, -1, 1]), np.full((4, 4), np.nan)):
        with pytest.raises(ValueError, match="not a rigid transform"):
            filter.update(3, bad, np.eye(6))
    with pytest.raises(ValueError, match=r"covariance: an array of shape \(6, 6\)"):
        filter.update(3, pose, np.eye(3))


def test_hand_is_mirrored_for_the_other_layout():
    hand = handyar.average_adult_hand()
    mirrored = hand.for_layout("thumb_left")
    np.testing.assert_allclose(mirrored.tips_m, hand.tips_m * [-1, 1, 1])
    assert (hand.layout, mirrored.layout) == ("thumb_right", "thumb_left")
    assert hand.scale_assumed and 0.1 < hand.span_m < 0.3
    with pytest.raises(ValueError, match="'thumb_right' or 'thumb_left'"):
        hand.for_layout("left")
