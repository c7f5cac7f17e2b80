// SPDX-License-Identifier: MIT
// What the page says.

/** Why the camera cannot be had, and what helps. */
export function cameraFault(error) {
  if (!navigator.mediaDevices) return 'Browsers give a camera only to pages from https or from this machine.';
  switch (error.name) {
    case 'NotAllowedError':
      return 'The camera was refused. Allow it for this page, by the camera sign beside its address, and start again.';
    case 'NotFoundError':
    case 'OverconstrainedError':
      return 'No camera is connected. Connect one and start again, or watch a recorded hand.';
    case 'NotReadableError':
      return 'The camera does not answer: it was disconnected, or another program is using it.';
    default:
      return `It did not start: ${error.message}`;
  }
}

const SLOW_per_s = 12;
const LONG_s = 6;
const WINDOW_s = 3;

/** Tells from the pictures so far what to say of them. */
export class Teller {
  #times_s = [];
  #hand_s = null;  // when there was a hand last; at first, when looking began

  /** `video`: a recorded one, which has the rate that it has. */
  say({ time_s, state, doubtful, held_pose }, video) {
    this.#times_s = this.#times_s.filter((t) => t > time_s - WINDOW_s).concat(time_s);
    this.#hand_s ??= time_s;
    if (state === 'tracking' || held_pose) {  // held: it is there, with folded fingers
      this.#hand_s = time_s;
      if (doubtful) return 'Show the open hand again.';
      return video ? '' : this.#sayRate(time_s);
    }
    if (time_s - this.#hand_s > LONG_s)
      return 'No hand is found. Hold it open, fingers spread, an arm’s length away, in even light.';
    return 'Hold up an open hand, fingers spread.';
  }

  #sayRate(time_s) {
    const watched_s = time_s - this.#times_s[0];
    const rate_per_s = (this.#times_s.length - 1) / watched_s;
    if (watched_s < 0.8 * WINDOW_s || rate_per_s > SLOW_per_s) return '';
    return `Only ${Math.round(rate_per_s)} pictures a second come in: more light makes most cameras faster, ` +
      'and what else runs makes this machine slower.';
  }
}
