// Draws random scenes with Galacean's engine over hardware that draws nothing and records in which order it draws which
// sub-mesh of which renderer. -> fixtures/galacean.json
import { drawText, packageVersion, writeFixture } from './fixture.js';
import { Random } from './random.js';
import { WebGLMock } from './webgl_mock.js';

const SCENES = 600;

// Anything that the engine asks of a browser and that has no say in the order.
function inert(members = {}) {
  return new Proxy(members, {
    get: (target, name) => {
      if (name in target) return target[name];
      return typeof name === 'symbol' || name === 'then' ? undefined : () => inert();
    },
  });
}

// The engine is written for a browser, and runs without input where its canvas is off the screen.
globalThis.window = globalThis;
globalThis.document = inert();
globalThis.AudioContext = class {};
globalThis.OffscreenCanvas = class {
  getContext() {
    return inert();
  }
};
// The build that has RenderQueue and the pipeline in it, by its file.
const galacean = await import('./node_modules/@galacean/engine-core/dist/module.js');
const { Vector3 } = await import('@galacean/engine-math');

const cutoffMacro = galacean.ShaderMacro.getByName('MATERIAL_IS_ALPHA_CUTOFF');

const mock = new WebGLMock();
mock.culling = mock.depthTest = true;  // the state in which the engine expects to find a device
const hardware = inert({
  gl: mock.context(),
  isWebGL2: true,
  canIUse: () => false,
  isContextLost: () => false,
  capability: { maxTextureSize: 4096, maxAntiAliasing: 1, canIUse: () => false, rendererMaxUniform: 1024 },
  _options: { depth: true, stencil: true },
  renderStates: {},
});
const canvas = { width: 64, height: 64, _sizeUpdateFlagManager: inert(), _webCanvas: new OffscreenCanvas() };
const engine = new galacean.Engine(canvas, hardware, {});

function randomMaterial(random) {
  const { RenderFace } = galacean;
  const material = new galacean.UnlitMaterial(engine);
  const settings = random.shuffled([
    () => (material.isTransparent = random.chance(0.5)),
    () => (material.alphaCutoff = random.pick([0, 0, 0.5])),
  ]);
  for (const set of settings) set();
  material.renderFace = random.pick([RenderFace.Front, RenderFace.Back, RenderFace.Double]);
  if (random.chance(0.15)) material.renderState.depthState.writeEnabled = random.chance(0.5);
  if (random.chance(0.1)) material.renderState.depthState.enabled = false;
  return material;
}

function randomRenderer(random, root, coordinates, materials) {
  const entity = root.createChild();
  const renderer = entity.addComponent(galacean.MeshRenderer);
  const mesh = new galacean.ModelMesh(engine);
  const subMeshes = random.chance(0.15) ? 2 : 1;
  for (let i = 0; i < subMeshes; ++i) mesh.addSubMesh(3 * i, 3);
  // World matrices are float32, so what differs in the last bits of a double must do so in the mesh.
  const inMesh = ['sphere', 'close'].includes(coordinates);
  const centre = random.point(coordinates);
  const halfExtent = random.pick([0.5, 1, 1]);
  mesh.bounds.min.set(...centre.map((x) => (inMesh ? x : 0) - halfExtent));
  mesh.bounds.max.set(...centre.map((x) => (inMesh ? x : 0) + halfExtent));
  if (!inMesh) entity.transform.setPosition(...centre);
  renderer.mesh = mesh;
  for (let i = 0; i < subMeshes; ++i) renderer.setMaterial(i, random.pick(materials));
  renderer.priority = random.pick([0, 0, 0, 1, -1, 0.5]);
}

function randomCamera(random, root) {
  const entity = root.createChild();
  const camera = entity.addComponent(galacean.Camera);
  entity.transform.setPosition(...random.pick([[0, 0, 0], [0, 0, 8], [3, -2, 5]]));
  if (random.chance(0.5)) entity.transform.lookAt(new Vector3(1, 2, -4));
  camera.isOrthographic = random.chance(0.5);
  camera.enableFrustumCulling = false;
  return camera;
}

function recordScene(random) {
  const scene = new galacean.Scene(engine);
  engine.sceneManager.addScene(scene);
  const root = scene.createRootEntity();
  const coordinates = random.coordinates();
  const materials = Array.from({ length: random.pick([1, 2, 6]) }, () => randomMaterial(random));
  for (let i = random.integer(2, 28); i > 0; --i) randomRenderer(random, root, coordinates, materials);
  const camera = randomCamera(random, root);

  const pipeline = camera._renderPipeline;
  const push = pipeline.pushRenderElement;
  const items = [];
  const subMeshes = [];
  pipeline.pushRenderElement = (context, element) => {
    for (const { component, material, subPrimitive } of element.subRenderElements) {
      const { min, max } = component.bounds;
      subMeshes.push(subPrimitive);
      items.push([
        materials.indexOf(material),
        component.priority,
        [min.x, min.y, min.z],
        [max.x, max.y, max.z],
        element.distanceForSort,
      ]);
    }
    push.call(pipeline, context, element);
  };
  const draws = [];
  hardware.drawPrimitive = (_primitive, subPrimitive) => {
    const item = subMeshes.indexOf(subPrimitive);
    if (item < 0) return;  // the picture as a whole
    draws.push(
      drawText({
        item,
        faces: mock.faces(engine._renderContext.flipProjection),
        noDepthWrite: !mock.depthWrite,
        noDepthTest: !mock.depthTest,
        alphaTest: materials[items[item][0]].shaderData._macroCollection.isEnable(cutoffMacro),
      }),
    );
  };
  engine.update();

  const { position, forward, isOrthographic } = camera._virtualCamera;
  const recorded = {
    isOrthographic,
    position: [position.x, position.y, position.z],
    forward: isOrthographic ? [forward.x, forward.y, forward.z] : [0, 0, 0],
    materials: materials.map((material) => [
      material.isTransparent,
      material.alphaCutoff,
      material.renderFace,
      material.renderState.depthState.writeEnabled,
      material.renderState.depthState.enabled,
    ]),
    items,
    draws: draws.join(' '),
  };
  scene.destroy();
  return recorded;
}

const random = new Random(1613);
writeFixture(
  'galacean',
  packageVersion('@galacean/engine-core'),
  Array.from({ length: SCENES }, () => recordScene(random)),
);
