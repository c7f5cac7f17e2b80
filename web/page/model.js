// SPDX-License-Identifier: MIT
// What stands on the hand.
import { AnimationMixer, Box3, Group, Mesh, MeshStandardMaterial, Vector3 } from 'three';
import { TeapotGeometry } from 'three/addons/geometries/TeapotGeometry.js';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';

const LONGEST_SIDE_m = 0.09;

/** Its foot at the origin, its longest side as given. */
function stood(model) {
  const box = new Box3().setFromObject(model);
  const size = box.getSize(new Vector3()), centre = box.getCenter(new Vector3());
  const longest = Math.max(size.x, size.y, size.z);
  if (!(longest > 0)) throw new Error('there is nothing in it to be seen');
  model.position.sub(new Vector3(centre.x, box.min.y, centre.z));
  model.traverse((part) => { part.castShadow = part.receiveShadow = part.isMesh === true; });
  const stand = new Group().add(model);
  stand.scale.setScalar(LONGEST_SIDE_m / longest);
  return new Group().add(stand);
}

export function teapot() {
  const material = new MeshStandardMaterial({ color: 0xd9822b, roughness: 0.35, metalness: 0.05 });
  return stood(new Mesh(new TeapotGeometry(1, 12), material));
}

/**
 * A model from a .glb file, or from a .gltf file that has everything in it, and what moves it: its
 * first animation, over and over, or null.
 */
export async function modelFrom(file) {
  try {
    const { scene, animations } = await new GLTFLoader().parseAsync(await file.arrayBuffer(), '');
    const model = stood(scene);
    if (animations.length === 0) return { model, mixer: null };
    const mixer = new AnimationMixer(scene);
    mixer.clipAction(animations[0]).play();
    return { model, mixer };
  } catch (error) {
    const reason = /Unexpected token|JSON/.test(error.message) ? 'it is not glTF' : error.message;
    throw new Error(`${file.name} cannot be shown: ${reason}`);
  }
}
