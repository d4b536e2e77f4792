// Draws random scenes with three.js's own WebGLRenderer over a context that draws nothing, and records in which order
// it draws which faces of which object. -> fixtures/three.json
import * as THREE from 'three';

import { drawText, packageVersion, writeFixture } from './fixture.js';
import { Random } from './random.js';
import { WebGLMock } from './webgl_mock.js';

const SCENES = 510;

// Comparators that a user might set; tests/scene/three_fixture_test.cpp has the same by name.
const comparators = {
  near_to_far: (a, b) => a.z - b.z,
  far_to_near: (a, b) => b.z - a.z,
  last_first: (a, b) => b.id - a.id,
  render_order_only: (a, b) => a.renderOrder - b.renderOrder,
  all_equal: () => 0,
};

function randomCamera(random) {
  const camera = random.chance(0.5)
    ? new THREE.PerspectiveCamera(random.pick([30, 45, 90]), 1, 0.1, 100)
    : new THREE.OrthographicCamera(-6, 6, 6, -6, 0.1, 100);
  camera.position.set(...random.pick([[0, 0, 8], [0, 0, 8], [3, -2, 5], [0, 0, 0.5]]));
  if (random.chance(0.5)) camera.lookAt(0, 0, 0);
  return camera;
}

function randomMaterial(random) {
  const transmission = random.chance(0.25) ? random.pick([0.5, 1]) : 0;
  const material = transmission > 0 ? new THREE.MeshPhysicalMaterial({ transmission }) : new THREE.MeshBasicMaterial();
  material.transparent = random.chance(0.5);
  material.side = random.pick([THREE.FrontSide, THREE.BackSide, THREE.DoubleSide, THREE.DoubleSide]);
  material.forceSinglePass = random.chance(0.3);
  material.depthWrite = random.chance(0.8);
  material.depthTest = random.chance(0.9);
  return material;
}

// Two triangles around `centre`, each in a group of its own for those who have two materials.
function triangles(centre) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(18), 3));
  geometry.boundingSphere = new THREE.Sphere(new THREE.Vector3(...centre), 1);
  geometry.addGroup(0, 3, 0);
  geometry.addGroup(3, 3, 1);
  return geometry;
}

function randomScene(random) {
  const coordinates = random.coordinates();
  const scene = new THREE.Scene();
  const materials = Array.from({ length: random.integer(1, 6) }, () => randomMaterial(random));
  const geometries = [triangles([0, 0, 0]), triangles(random.point(coordinates))];
  const parents = [scene];
  for (let i = random.integer(0, 3); i > 0; --i) {
    const group = new THREE.Group();
    group.renderOrder = random.integer(-1, 1);
    random.pick(parents).add(group);
    parents.push(group);
  }
  const turned = random.chance(0.15);
  const meshes = Array.from({ length: random.integer(2, 21) }, () => {
    const two = random.chance(0.15);
    const mesh = new THREE.Mesh(
      random.pick(geometries),
      two ? [random.pick(materials), random.pick(materials)] : random.pick(materials),
    );
    mesh.position.set(...random.point(coordinates));
    if (turned) mesh.quaternion.set(...random.point('any'), 1).normalize();
    if (turned) mesh.scale.setScalar(random.pick([0.5, 1, 3]));
    mesh.renderOrder = random.pick([0, 0, 0, 1, -1, 0.5]);
    mesh.frustumCulled = false;
    return mesh;
  });
  for (const mesh of random.shuffled(meshes)) {  // so that ids are not in the order of the graph
    random.pick(parents).add(mesh);
    if (random.chance(0.1)) parents.push(mesh);
  }
  return { scene, materials };
}

// Three numbers where it only moves.
function matrixNumbers({ elements }) {
  const moves = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0].every((element, i) => elements[i] === element);
  return moves ? elements.slice(12, 15) : elements;
}

const mock = new WebGLMock();
const context = mock.context();
const renderer = new THREE.WebGLRenderer({ canvas: context.canvas, context });

function recordScene(random) {
  const { scene, materials } = randomScene(random);
  const camera = randomCamera(random);
  const custom = random.chance(0.25);
  const opaqueSort = custom && random.chance(0.7) ? random.pick(Object.keys(comparators)) : null;
  const transparentSort = custom && random.chance(0.7) ? random.pick(Object.keys(comparators)) : null;
  renderer.setOpaqueSort(opaqueSort ? comparators[opaqueSort] : null);
  renderer.setTransparentSort(transparentSort ? comparators[transparentSort] : null);
  renderer.sortObjects = !random.chance(0.05);

  const pushed = [];  // what is drawn as one: an object, or a group of its geometry
  const draws = [];
  let current;
  scene.traverse((object) => {
    if (!object.isMesh) return;
    for (const group of Array.isArray(object.material) ? object.geometry.groups : [null]) {
      pushed.push({ object, group });
    }
    object.onBeforeRender = (_renderer, _scene, _camera, _geometry, _material, group) => {
      current = pushed.findIndex((item) => item.object === object && item.group === group);
    };
  });
  mock.onDraw = () => {
    draws.push(
      drawText({
        item: current,
        faces: mock.faces(),
        noDepthWrite: !mock.depthWrite,
        noDepthTest: !mock.depthTest,
        transmission: mock.framebuffer !== null,
      }),
    );
  };
  renderer.render(scene, camera);

  const { opaque, transmissive, transparent } = renderer.renderLists.get(scene, 0);
  const listed = [...opaque, ...transmissive, ...transparent];
  const matrices = [];
  const items = pushed.map(({ object, group }) => {
    const item = listed.find((candidate) => candidate.object === object && candidate.group === group);
    const text = JSON.stringify(matrixNumbers(object.matrixWorld));
    if (!matrices.includes(text)) matrices.push(text);
    return [
      item.id,
      materials.indexOf(item.material),
      item.groupOrder,
      item.renderOrder,
      matrices.indexOf(text),
      object.geometry.boundingSphere.center.toArray(),
      renderer.sortObjects ? item.z : 0,
    ];
  });
  scene.traverse((object) => object.geometry?.dispose());
  materials.forEach((material) => material.dispose());
  renderer.renderLists.dispose();
  return {
    perspective: camera.isPerspectiveCamera === true,
    projection: camera.projectionMatrix.elements,
    view: camera.matrixWorldInverse.elements,
    sortObjects: renderer.sortObjects,
    opaqueSort,
    transparentSort,
    materials: materials.map((material) => [
      material.id,
      material.transmission ?? 0,
      material.transparent,
      material.side,
      material.forceSinglePass,
      material.depthWrite,
      material.depthTest,
    ]),
    matrices: matrices.map((text) => JSON.parse(text)),
    items,
    draws: draws.join(' '),
  };
}

const random = new Random(176);
writeFixture('three', packageVersion('three'), Array.from({ length: SCENES }, () => recordScene(random)));
