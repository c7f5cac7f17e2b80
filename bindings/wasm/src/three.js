// SPDX-License-Identifier: MIT
// The hand in a three.js scene, after the habits of mind-ar-js. What everything means is said in
// three.d.ts.
import { Camera, DirectionalLight, HemisphereLight, SRGBColorSpace, Scene, Vector2, Vector3,
  VideoFrameTexture, WebGLRenderer } from 'three';

import { Anchor } from './anchor.js';
import { HandSurface } from './hand_surface.js';
import { LiveTracker } from './live.js';
import { projectionMatrix } from './pose.js';

export { Anchor };

const TURN_rad_px = 0.01;
const lamp_m = new Vector3(0.08, 0.3, 0.4);  // of the lamp from the hand: above the camera

const end = (stream) => stream.getTracks().forEach((track) => track.stop());

const now_s = () => performance.now() / 1000;

export class HandThree {
  renderer = new WebGLRenderer({ antialias: true });
  scene = new Scene();
  camera = new Camera();
  lamp = new DirectionalLight(0xffffff, 2.5);
  onUpdate = null;
  onError = console.error;
  #container;
  #options;
  #facing;
  #video = document.createElement('video');
  #run = null;  // stands for what start() began, also while it still waits; gone after stop()
  #live = null;
  #anchors = [];
  #surface = new HandSurface();

  constructor({ container, facing = 'user', camera, hand, wasm }) {
    this.#container = container;
    this.#facing = facing;
    this.#options = { camera, hand, wasm };
    this.#video.muted = this.#video.playsInline = true;
    this.#prepareCanvas();
    this.#prepareScene();
  }

  get facing() {
    return this.#facing;
  }

  /** Begins with the camera, or with a video that lies at `src`. */
  async start(src = null) {
    if (this.#run) return;
    const run = this.#run = {};
    const stopped = () => this.#run !== run;
    try {
      if (src) {
        this.#video.src = src;
        this.#video.loop = true;
      } else {
        const stream = await navigator.mediaDevices.getUserMedia({
          audio: false,
          video: { facingMode: this.#facing, width: { ideal: 640 }, height: { ideal: 480 } } });
        if (stopped()) return end(stream);
        this.#video.srcObject = stream;
        stream.getVideoTracks()[0].onended = () => {
          this.stop();
          this.onError(new DOMException('the camera was disconnected', 'NotReadableError'));
        };
      }
      await this.#video.play();
      if (stopped()) return;
      const live = await LiveTracker.start(this.#video, {
        ...this.#options, places: this.#places(), onFrame: (tracked) => this.#take(tracked),
        onError: (error) => this.onError(error) });
      if (stopped()) return live.stop();
      this.#live = live;
    } catch (error) {
      if (stopped()) return;
      this.stop();
      throw error;
    }
  }

  stop() {
    this.#run = null;
    this.#live?.stop();
    this.#live = null;
    if (this.#video.srcObject) end(this.#video.srcObject);
    this.#video.srcObject = null;
    this.#video.removeAttribute('src');
    this.#surface.hide();
  }

  async switchCamera() {
    this.stop();
    this.#facing = this.#facing === 'user' ? 'environment' : 'user';
    await this.start();
  }

  addAnchor(place) {
    const anchor = new Anchor(place);
    this.#anchors.push(anchor);
    this.scene.add(anchor.group);
    if (this.#live) this.#live.places = this.#places();
    return anchor;
  }

  hand() {
    return this.#live ? this.#live.hand() : Promise.resolve(this.#options.hand ?? null);
  }

  async setHand(hand) {
    this.#options.hand = hand;
    await this.#live?.setHand(hand);
  }

  async setCamera(camera) {
    await this.#live?.setCamera(camera);
    this.#options.camera = camera;
  }

  predict(time_s) {
    return this.#live?.predict(time_s) ?? null;
  }

  #places() {
    return [...new Set(this.#anchors.map((anchor) => anchor.place))];
  }

  #prepareCanvas() {
    const canvas = this.renderer.domElement;
    Object.assign(canvas.style, {
      display: 'block', width: '100%', height: '100%', objectFit: 'cover', touchAction: 'none' });
    canvas.addEventListener('pointermove', (event) => {
      if (!event.buttons) return;
      const mirrored = new DOMMatrix(getComputedStyle(canvas).transform).a < 0;
      const right_px = mirrored ? -event.movementX : event.movementX;
      for (const anchor of this.#anchors)
        anchor.turn(TURN_rad_px * right_px, TURN_rad_px * event.movementY);
    });
    this.#container.append(canvas);
  }

  #prepareScene() {
    this.renderer.shadowMap.enabled = true;
    this.lamp.castShadow = true;
    this.lamp.shadow.mapSize.set(1024, 1024);
    this.lamp.shadow.radius = 6;
    this.lamp.shadow.bias = -0.002;
    Object.assign(this.lamp.shadow.camera, {
      left: -0.2, right: 0.2, bottom: -0.2, top: 0.2, near: 0.05, far: 1 });
    this.lamp.position.copy(lamp_m);
    this.scene.add(this.lamp, this.lamp.target, this.#surface, new HemisphereLight(0xffffff, 0x9a8878, 1.2));
    this.scene.background = new VideoFrameTexture();
    this.scene.background.colorSpace = SRGBColorSpace;
    this.scene.onBeforeRender = () => {
      for (const anchor of this.#anchors) {
        anchor.move(now_s());
        anchor.group.updateMatrixWorld(true);
      }
    };
  }

  #take(tracked) {
    const { frame, result, mask, camera } = tracked;
    this.#showPicture(frame, camera);
    for (const anchor of this.#anchors) anchor.take(tracked, now_s());
    const pose = result.pose ?? result.held_pose;
    if (pose && mask) {
      this.#surface.show(pose.T_gl_hand, mask, this.renderer.getDrawingBufferSize(new Vector2()));
      this.lamp.target.position.setFromMatrixPosition(this.#surface.matrix);
      this.lamp.position.addVectors(this.lamp.target.position, lamp_m);
    } else {
      this.#surface.hide();
    }
    this.onUpdate?.(tracked);
  }

  /** The picture becomes the background; the scene's camera sees what the real one saw. */
  #showPicture(frame, camera) {
    const texture = this.scene.background;
    const { width, height } = this.renderer.getSize(new Vector2());
    if (width !== camera.width_px || height !== camera.height_px) {
      texture.dispose();
      const wanted = this.#container.clientWidth * devicePixelRatio / camera.width_px;
      this.renderer.setPixelRatio(Math.min(2, Math.max(1, wanted)));
      this.renderer.setSize(camera.width_px, camera.height_px, false);
    }
    this.camera.projectionMatrix.fromArray(projectionMatrix(camera));
    this.camera.projectionMatrixInverse.copy(this.camera.projectionMatrix).invert();
    texture.setFrame(frame);
    this.renderer.initTexture(texture);  // now: the picture is closed after this
  }
}
