// SPDX-License-Identifier: MIT
// The tracker in a worker of its own; live.js is the other side.
import { HandTracker } from './handyar.js';

let tracker = null;

const answers = {
  async create({ options }) {
    tracker = await HandTracker.create(options);
  },
  process({ frame, time_s, places }) {
    try {
      const result = tracker.process(frame, time_s);
      const known = result.pose ?? result.held_pose ? places.map((place) => [place, tracker.T_hand_object(place)]) : [];
      return {
        result, mask: tracker.mask(), places: Object.fromEntries(known), camera: tracker.camera };
    } finally {
      frame.close();
    }
  },
  hand: () => tracker.hand(),
  setHand: ({ hand }) => tracker.setHand(hand),
  setCamera: ({ camera }) => tracker.setCamera(camera),
};

self.onmessage = async ({ data }) => {
  try {
    const answer = await answers[data.ask](data);
    const transfer = answer?.mask ? [answer.mask.data.buffer] : [];
    self.postMessage({ id: data.id, answer }, transfer);
  } catch (error) {
    self.postMessage({ id: data.id, error: error.message });
  }
};
