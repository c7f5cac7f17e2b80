// SPDX-License-Identifier: MIT

/** The rotation by `turn_rad` about the vector of the same direction: 3x3, by rows. */
function rotationOf(turn_rad) {
  const angle_rad = Math.hypot(...turn_rad);
  if (angle_rad === 0) return [1, 0, 0, 0, 1, 0, 0, 0, 1];
  const [x, y, z] = turn_rad.map((w) => w / angle_rad);
  const c = Math.cos(angle_rad), s = Math.sin(angle_rad), d = 1 - c;
  return [
    c + d * x * x, d * x * y - s * z, d * x * z + s * y,
    d * x * y + s * z, c + d * y * y, d * y * z - s * x,
    d * x * z - s * y, d * y * z + s * x, c + d * z * z];
}

/** OpenCV's camera looks along +z with y down, WebGL's along -z with y up. */
export function toGl(T_camera_hand) {
  return T_camera_hand.map((x, i) => (i % 4 === 1 || i % 4 === 2 ? -x : x));
}

/** The pose carried to `time_s` with the velocities that it has. */
export function predictPose(pose, time_s) {
  const dt_s = time_s - pose.time_s;
  const turn = rotationOf(pose.angular_velocity_rad_s.map((w) => w * dt_s));
  const T_camera_hand = pose.T_camera_hand.slice();
  for (let column = 0; column < 3; ++column)
    for (let row = 0; row < 3; ++row)
      T_camera_hand[4 * column + row] = turn[3 * row] * pose.T_camera_hand[4 * column] +
        turn[3 * row + 1] * pose.T_camera_hand[4 * column + 1] +
        turn[3 * row + 2] * pose.T_camera_hand[4 * column + 2];
  for (let row = 0; row < 3; ++row) T_camera_hand[12 + row] += dt_s * pose.velocity_m_s[row];
  return { ...pose, time_s, T_camera_hand, T_gl_hand: toGl(T_camera_hand) };
}

/** WebGL's projection, column-major, of a camera without its distortion. */
export function projectionMatrix(camera, near_m = 0.02, far_m = 10) {
  const { width_px: w, height_px: h, fx_px, fy_px, cx_px, cy_px } = camera;
  const depth_m = far_m - near_m;
  // The centre of the top-left pixel is (0, 0), so the picture covers -0.5 to w - 0.5.
  return [
    2 * fx_px / w, 0, 0, 0,
    0, 2 * fy_px / h, 0, 0,
    1 - 2 * (cx_px + 0.5) / w, 2 * (cy_px + 0.5) / h - 1, -(far_m + near_m) / depth_m, -1,
    0, 0, -2 * far_m * near_m / depth_m, 0];
}
