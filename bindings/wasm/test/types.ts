// SPDX-License-Identifier: MIT
// Compiled, not run: a program as its types allow it.
import { FINGERS, HandTracker, LiveTracker, cameraFromFieldOfView, projectionMatrix, readHand } from 'handyar';
import type { Pose, Result } from 'handyar';
import { HandThree } from 'handyar/three';
import type { Anchor } from 'handyar/three';
import { WebXrHand } from 'handyar/webxr';
import { XRDevice, metaQuest3 } from 'iwer';
import type { Object3D } from 'three';

export async function track(bitmap: ImageBitmap, video: HTMLVideoElement): Promise<Float32Array> {
  const camera = cameraFromFieldOfView(640, 480);
  const tracker = await HandTracker.create({ camera, hand: readHand('{}') });
  const [, second] = await HandTracker.createPair({ camera });
  second.process(bitmap, 1.5);
  const result: Result = tracker.process(bitmap, 1.5);
  const pose: Pose | null = result.pose ?? tracker.predict(1.6);
  const live = await LiveTracker.start(video, {
    onFrame: ({ frame, mask }) => console.log(frame.displayWidth, mask?.width) });
  live.stop();
  // @ts-expect-error: a state has one of four names
  if (result.state === 'found') console.log(FINGERS[0]);
  return new Float32Array(pose?.T_gl_hand ?? projectionMatrix(camera));
}

export async function standOnPalm(container: HTMLElement, model: Object3D): Promise<void> {
  const hand = new HandThree({ container, facing: 'environment' });
  const anchor: Anchor = hand.addAnchor('palm');
  anchor.group.add(model);
  anchor.onLost = () => { anchor.group.visible = false; };
  // @ts-expect-error: there is no elbow on a hand
  hand.addAnchor('elbow');
  await hand.start();
  hand.renderer.setAnimationLoop(() => hand.renderer.render(hand.scene, hand.camera));
}

export async function enterXr(video: HTMLVideoElement): Promise<void> {
  const device = new XRDevice(metaQuest3);
  const hand = new WebXrHand(device, { facing: 'environment' });
  // @ts-expect-error: a camera looks at the person or with them
  new WebXrHand(device, { facing: 'up' });
  await LiveTracker.start(video, { onFrame: (tracked) => hand.take(tracked) });
}
