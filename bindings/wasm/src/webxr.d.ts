// SPDX-License-Identifier: MIT
import type { Result } from './handyar.js';

/** As `XRDevice` of iwer has them, in metres, in the world of the emulated device. */
interface Placed {
  readonly position: { x: number; y: number; z: number; set(x: number, y: number, z: number): unknown };
  readonly quaternion:
    { x: number; y: number; z: number; w: number; set(x: number, y: number, z: number, w: number): unknown };
}

/** The part of iwer's `XRDevice` that is moved. */
export interface EmulatedDevice extends Placed {
  primaryInputMode: string;
  readonly hands: { left?: Placed & { connected: boolean }; right?: Placed & { connected: boolean } };
}

export interface WebXrHandOptions {
  /** A camera that looks at the person, or with them. `user` if nothing is said. */
  facing?: 'user' | 'environment';
  /** How far before the eyes the camera is; 0.6 for `user`, 0 for `environment` if nothing is said. */
  eyes_to_camera_m?: number;
}

/**
 * The hand before a camera as an input source of WebXR, through the emulated device of the npm
 * package iwer, so that pages made for headsets run with a webcam:
 *
 *     const device = new XRDevice(metaQuest3);
 *     device.installRuntime();
 *     const hand = new WebXrHand(device);
 *     await LiveTracker.start(video, { onFrame: (tracked) => hand.take(tracked) });
 *
 * The device's hand is where the real one is from the eyes, points along the fingers and has its back
 * up; it is connected while there is a pose to be relied on, and while it closes, where its palm is.
 * How its fingers bend is the device's own.
 */
export class WebXrHand {
  constructor(device: EmulatedDevice, options?: WebXrHandOptions);
  take(tracked: { result: Result }): void;
}
