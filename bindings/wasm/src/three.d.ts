// SPDX-License-Identifier: MIT
import type { Camera, DirectionalLight, Group, Scene, WebGLRenderer } from 'three';

import type { Camera as CameraModel, Hand, Options, Place, Pose, Tracked } from './handyar.js';

/**
 * A place on the hand. What is put into `group` follows the hand: metres, +y up from the hand (for a
 * fingertip: along the finger), +z towards the wrist, so that a model with its feet at the origin
 * stands on the hand and looks at who holds it. While the hand closes it stays on the palm. When the
 * hand is lost it stays where it was last and can be turned with the pointer; when the hand is seen
 * again it glides back within half a second. To hide it instead:
 * `anchor.onLost = () => { anchor.group.visible = false; }`.
 */
export class Anchor {
  readonly place: Place;
  readonly group: Group;
  /** Whether it follows the hand now. */
  readonly followed: boolean;
  onFound: (() => void) | null;
  onLost: (() => void) | null;
  /** It was moved, before the scene is drawn. */
  onUpdate: (() => void) | null;
  /** Turns what stays while the hand is away, as dragging does. */
  turn(about_y_rad: number, about_x_rad: number): void;
}

export interface HandThreeOptions extends Options {
  /** The canvas fills it, as `object-fit: cover` does; mirror it by CSS, `transform: scaleX(-1)` on the canvas. */
  container: HTMLElement;
  /** Which of a phone's cameras; `user` if nothing is said. */
  facing?: 'user' | 'environment';
}

/**
 * The hand in a three.js scene. The picture that is shown is the one that the pose belongs to, so
 * that objects do not lag behind the hand. An invisible surface in the hand's place hides what is
 * behind the hand and shows the lamp's shadow of all that has `castShadow`.
 *
 *     const hand = new HandThree({ container: document.body });
 *     hand.addAnchor('palm').group.add(teapot);
 *     await hand.start();
 *     hand.renderer.setAnimationLoop(() => hand.renderer.render(hand.scene, hand.camera));
 */
export class HandThree {
  constructor(options: HandThreeOptions);
  readonly renderer: WebGLRenderer;
  readonly scene: Scene;
  /** Sees what the real camera sees, in metres; at the origin, looking along -z. */
  readonly camera: Camera;
  /** Above the camera; its shadows fall on the hand. */
  readonly lamp: DirectionalLight;
  readonly facing: 'user' | 'environment';
  /** A picture was tracked. */
  onUpdate: ((tracked: Tracked) => void) | null;
  /** A picture could not be tracked; NotReadableError: the camera was disconnected, and all is stopped. */
  onError: (error: Error) => void;
  /**
   * Begins with the camera, or with a video that lies at `src`. Rejects with what getUserMedia()
   * says: NotAllowedError, NotFoundError, NotReadableError, ... A stop() meanwhile ends it.
   */
  start(src?: string): Promise<void>;
  stop(): void;
  /** From the front camera to the back one, or back. */
  switchCamera(): Promise<void>;
  addAnchor(place: Place): Anchor;
  /** The hand as far as it was learned. */
  hand(): Promise<Hand | null>;
  setHand(hand: Hand | null): Promise<void>;
  /** Of the camera in use; null: an assumed one. */
  setCamera(camera: CameraModel | null): Promise<void>;
  /** The pose expected at `time_s` (performance.now() / 1000), for displays that show no picture. */
  predict(time_s: number): Pose | null;
}
