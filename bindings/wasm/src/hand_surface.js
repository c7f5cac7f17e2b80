// SPDX-License-Identifier: MIT
import { CustomBlending, DataTexture, LinearFilter, Mesh, OneFactor, PlaneGeometry, RedFormat,
  ShadowMaterial, Vector2, ZeroFactor } from 'three';

const HALF_SIZE_m = 0.25;

/**
 * What stands in the hand's place in the scene: nothing is drawn of it, but it hides what is behind
 * the hand and shows the shadows that fall on it. It lies in the hand's plane and is cut out by the
 * hand's mask.
 */
export class HandSurface extends Mesh {
  #uniforms = { mask: { value: null }, canvas_px: { value: new Vector2() } };

  constructor() {
    const material = new ShadowMaterial({ opacity: 0.45 });
    // Drawn before everything else, for its depth, though it is mixed into what is there.
    material.transparent = false;
    material.blending = CustomBlending;
    material.blendSrcAlpha = ZeroFactor;
    material.blendDstAlpha = OneFactor;
    material.onBeforeCompile = (shader) => {
      Object.assign(shader.uniforms, this.#uniforms);
      shader.fragmentShader = shader.fragmentShader.replace('void main() {', `
        uniform sampler2D mask;
        uniform vec2 canvas_px;
        void main() {
          vec2 at = gl_FragCoord.xy / canvas_px;
          if (texture2D(mask, vec2(at.x, 1.0 - at.y)).r < 0.5) discard;`);
    };
    super(new PlaneGeometry(2 * HALF_SIZE_m, 2 * HALF_SIZE_m), material);
    this.receiveShadow = true;
    this.renderOrder = -1;
    this.matrixAutoUpdate = false;
    this.visible = false;
  }

  /** A hand in a picture: its pose, and its mask, which covers the canvas. */
  show(T_gl_hand, mask, canvas_px) {
    this.matrix.fromArray(T_gl_hand);
    this.matrixWorldNeedsUpdate = true;
    this.#uniforms.canvas_px.value.copy(canvas_px);
    this.#textureFor(mask).image.data = mask.data;
    this.#uniforms.mask.value.needsUpdate = true;
    this.visible = true;
  }

  hide() {
    this.visible = false;
  }

  #textureFor({ data, width, height }) {
    const uniform = this.#uniforms.mask;
    const size = uniform.value?.image;
    if (size?.width === width && size.height === height) return uniform.value;
    uniform.value?.dispose();
    uniform.value = new DataTexture(data, width, height, RedFormat);
    uniform.value.magFilter = uniform.value.minFilter = LinearFilter;
    return uniform.value;
  }
}
