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

/** Where a result says that the hand is: as seen, or held while fingers are folded; null in doubt. */
export function steadyPose({ pose, held_pose, doubtful }) {
  return doubtful ? null : pose ?? held_pose ?? null;
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

/** The product of two 4x4 matrices, column-major. */
export function multiply(a, b) {
  return Array.from({ length: 16 }, (_, i) => {
    const row = i % 4, column = i - row;
    return [0, 1, 2, 3].reduce((sum, k) => sum + a[4 * k + row] * b[column + k], 0);
  });
}

/** A rotation and what is added to it as a 4x4 matrix, column-major. */
export function rigid(position, { x, y, z, w }) {
  return [
    1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y), 0,
    2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x), 0,
    2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y), 0,
    position.x, position.y, position.z, 1];
}

/** The rotation of a 4x4 matrix, column-major, as a unit quaternion [x, y, z, w]. */
export function quaternionOf(T) {
  const [xx, , , , , yy, , , , , zz] = T;
  // Of the four squares the largest, so that nothing is divided by little.
  const squares = [1 + xx - yy - zz, 1 - xx + yy - zz, 1 - xx - yy + zz, 1 + xx + yy + zz];
  const sums = [
    [squares[0], T[1] + T[4], T[2] + T[8], T[6] - T[9]],
    [T[1] + T[4], squares[1], T[6] + T[9], T[8] - T[2]],
    [T[2] + T[8], T[6] + T[9], squares[2], T[1] - T[4]],
    [T[6] - T[9], T[8] - T[2], T[1] - T[4], squares[3]]];
  const largest = sums[squares.indexOf(Math.max(...squares))];
  return largest.map((v) => v / Math.hypot(...largest));
}
