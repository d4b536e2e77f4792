// Draws random scenes with Babylon.js under its NullEngine and records in which order it draws which faces of which
// sub-mesh, depth pre-passes included. -> fixtures/babylon.json, fixtures/babylon_7.json
import { drawText, packageVersion, writeFixture } from './fixture.js';
import { Random } from './random.js';

const SCENES = 520;

async function load(folder) {
  const from = (path) => import(`./node_modules/${folder}/${path}.js`);
  const modules = await Promise.all(
    [
      'Engines/nullEngine', 'Engines/thinEngine', 'Engines/Extensions/engine.alpha', 'scene', 'Cameras/freeCamera',
      'Cameras/camera', 'Materials/standardMaterial', 'Materials/multiMaterial', 'Materials/Textures/rawTexture',
      'Maths/math.vector', 'Meshes/mesh', 'Meshes/mesh.vertexData', 'Meshes/subMesh', 'Rendering/renderingGroup',
      'Rendering/renderingManager', 'Misc/logger',
    ].map(from),
  );
  const babylon = Object.assign({}, ...modules);
  babylon.Logger.LogLevels = babylon.Logger.ErrorLogLevel;
  return babylon;
}

class Recorder {
  constructor(babylon) {
    this.babylon = babylon;
    // In float32 matrices positions that nearly tie would be equal.
    const options = Object.assign(new babylon.NullEngineOptions(), { useHighPrecisionMatrix: true });
    this.engine = new babylon.NullEngine(options);
    // NullEngine draws nothing and keeps less state; what decides the depth mask is the WebGL engine's own.
    this.engine.setAlphaMode = function (...parameters) {
      this._gl = {};  // release 7 looks up blend factors in it
      babylon.ThinEngine.prototype.setAlphaMode.apply(this, parameters);
      this._gl = undefined;
    };
    this.engine.setState = (culling, _zOffset, _force, reverse, cullBackFaces) => {
      this.usual ??= reverse;  // of this sub-mesh, as its material asks first; no mesh is mirrored
      const cullsBacks = (cullBackFaces ?? true) === (reverse === this.usual);
      this.faces = !culling ? 'a' : cullsBacks ? 'f' : 'b';
    };
    this.engine.clear = (_colour, _backBuffer, depth) => (this.cleared = this.inGroups && depth);
    this.items = [];
    this.draws = [];
    this.engine.drawElementsType = () => {
      this.draws.push(
        drawText({
          item: this.items.indexOf(this.subMesh),
          faces: this.faces,
          noColour: !this.engine._colorWrite,
          noDepthWrite: !this.engine.getDepthWrite(),
          clearsDepth: this.cleared,
          alphaTest: this.subMesh.materialDefines.ALPHATEST,
        }),
      );
      this.cleared = false;
    };
    const recorder = this;
    const render = babylon.SubMesh.prototype.render;
    babylon.SubMesh.prototype.render = function (...parameters) {
      recorder.subMesh = this;
      recorder.usual = undefined;
      return render.apply(this, parameters);
    };
    // Babylon.js's own, and two that a user might write; tests/scene/babylon_fixture_test.cpp has them by name.
    this.comparators = {
      front_to_back: babylon.RenderingGroup.frontToBackSortCompare,
      back_to_front: babylon.RenderingGroup.backToFrontSortCompare,
      last_first: (a, b) => b.getMesh().uniqueId - a.getMesh().uniqueId,
      all_equal: () => 0,
    };
  }

  #texture(scene) {
    const texture = new this.babylon.RawTexture(new Uint8Array(4), 1, 1, 5, scene, false);
    texture.hasAlpha = true;
    texture.isBlocking = false;  // NullEngine never says that it is ready
    return texture;
  }

  #material(random, scene) {
    const material = new this.babylon.StandardMaterial('', scene);
    material.disableLighting = true;
    material.alpha = random.pick([1, 1, 0.5]);
    if (random.chance(0.6)) material.transparencyMode = random.integer(0, 3);
    if (random.chance(0.35)) material.diffuseTexture = this.#texture(scene);
    if (random.chance(0.1)) material.opacityTexture = this.#texture(scene);
    material.useAlphaFromDiffuseTexture = random.chance(0.4);
    material.needDepthPrePass = random.chance(0.3);
    material.backFaceCulling = random.chance(0.4);
    material.separateCullingPass = random.chance(0.4);
    material.cullBackFaces = random.chance(0.9);
    material.forceDepthWrite = random.chance(0.15);
    material.disableDepthWrite = random.chance(0.1);
    material.alphaMode = random.pick([2, 2, 2, 1, 0]);
    return material;
  }

  #mesh(random, scene, coordinates, materials, materialChance) {
    const mesh = new this.babylon.Mesh('', scene);
    const centre = random.chance(0.5) ? [0, 0, 0] : random.point(coordinates);
    const data = new this.babylon.VertexData();
    const corners = [[-1, -1, -1], [1, -1, 1], [0, 1, 0], [-1, 1, -1], [1, 1, 1], [0, -1, 0]];
    data.positions = corners.flatMap((corner) => corner.map((x, k) => centre[k] + x));
    data.indices = [0, 1, 2, 3, 4, 5];
    data.applyToMesh(mesh);
    const two = random.chance(0.15);
    if (two) {
      mesh.releaseSubMeshes();
      new this.babylon.SubMesh(0, 0, 3, 0, 3, mesh);
      new this.babylon.SubMesh(1, 3, 3, 3, 3, mesh);
    }
    if (random.chance(materialChance)) {
      mesh.material = random.pick(materials);
      if (two) {
        mesh.material = new this.babylon.MultiMaterial('', scene);
        mesh.material.subMaterials = [random.pick(materials), random.pick(materials)];
      }
    }
    mesh.position.set(...random.point(coordinates));
    mesh.alphaIndex = random.pick([mesh.alphaIndex, mesh.alphaIndex, 0, 1, -1]);
    mesh.renderingGroupId = random.pick([0, 0, 0, 1, 2, 3, 5]);
    mesh.visibility = random.pick([1, 1, 1, 0.5]);
    mesh.hasVertexAlpha = random.chance(0.1);
    mesh.alwaysSelectAsActiveMesh = true;
  }

  #camera(random, scene, coordinates) {
    const camera = new this.babylon.FreeCamera('', this.babylon.Vector3.Zero(), scene);
    // Seen from where its coordinates are equal, a point and its permutations are nearly as far.
    const position = coordinates === 'sphere' ? [0.3, 0.3, 0.3] : random.pick([[0, 0, 0], [0, 0, -8], [3, -2, 5]]);
    camera.position.set(...position);
    camera.setTarget(new this.babylon.Vector3(...random.pick([[0, 0, 100], [1, 2, -3]])));
    if (random.chance(0.5)) camera.mode = this.babylon.Camera.ORTHOGRAPHIC_CAMERA;
    return camera;
  }

  #settings(random, scene, groups) {
    const manager = scene._renderingManager;
    const disableDepthPrePass = 'disableDepthPrePass' in manager && random.chance(0.1);
    if (disableDepthPrePass) manager.disableDepthPrePass = true;
    const settings = Array.from({ length: groups }, (_, group) => {
      const autoClearDepth = random.chance(0.7);
      if (!autoClearDepth) scene.setRenderingAutoClearDepthStencil(group, random.chance(0.5), false);
      const names = [0, 0, 0].map(() => (random.chance(0.12) ? random.pick(Object.keys(this.comparators)) : null));
      if (names.some((name) => name)) {
        scene.setRenderingOrder(group, ...names.map((name) => this.comparators[name] ?? null));
      }
      return [autoClearDepth, ...names];
    });
    return { disableDepthPrePass, groups: settings };
  }

  async record(random) {
    const { Camera, RenderingManager, Scene } = this.babylon;
    const groups = random.pick([4, 4, 4, 6]);
    RenderingManager.MAX_RENDERINGGROUPS = groups;
    const scene = new Scene(this.engine);
    const coordinates = random.chance(0.2) ? 'sphere' : random.coordinates();
    const materials = Array.from({ length: random.integer(1, 8) }, () => this.#material(random, scene));
    const materialChance = random.chance(0.9) ? 1 : 0.7;
    for (let i = random.integer(2, 26); i > 0; --i) this.#mesh(random, scene, coordinates, materials, materialChance);
    const camera = this.#camera(random, scene, coordinates);
    const settings = this.#settings(random, scene, groups);

    scene.render();  // asks for the shaders
    while (!scene.isReady()) await new Promise(setImmediate);
    this.items = [];
    this.draws = [];
    this.inGroups = this.cleared = false;
    const dispatch = scene._renderingManager.dispatch;
    scene._renderingManager.dispatch = (subMesh, ...rest) => {
      this.items.push(subMesh);
      dispatch.call(scene._renderingManager, subMesh, ...rest);
    };
    scene.onBeforeRenderingGroupObservable.add(() => (this.inGroups = true));
    scene.render();

    const used = [...new Set(this.items.map((subMesh) => subMesh.getMaterial()))];
    const recorded = {
      perspective: camera.mode === Camera.PERSPECTIVE_CAMERA,
      camera: camera.globalPosition.asArray(),
      ...settings,
      materials: used.map((material) => [
        material.alpha,
        material.transparencyMode,
        material.diffuseTexture?.hasAlpha ?? false,
        material.useAlphaFromDiffuseTexture,
        material.opacityTexture != null,
        material.needDepthPrePass,
        material.backFaceCulling,
        material.separateCullingPass,
        material.cullBackFaces,
        material.forceDepthWrite,
        material.disableDepthWrite,
        material.alphaMode,
      ]),
      items: this.items.map((subMesh) => {
        const mesh = subMesh.getMesh();
        return [
          used.indexOf(subMesh.getMaterial()),
          mesh.material?.uniqueId ?? null,
          mesh.uniqueId,
          mesh.renderingGroupId,
          mesh.alphaIndex === Number.MAX_VALUE ? null : mesh.alphaIndex,
          mesh.visibility,
          mesh.hasVertexAlpha,
          ...subMesh.getBoundingInfo().boundingSphere.centerWorld.asArray(),
        ];
      }),
      draws: this.draws.join(' '),
    };
    scene.dispose();
    return recorded;
  }
}

async function recordPackage(folder, name, seed) {
  const recorder = new Recorder(await load(folder));
  const random = new Random(seed);
  const scenes = [];
  while (scenes.length < SCENES) scenes.push(await recorder.record(random));
  writeFixture(name, packageVersion(folder), scenes);
}

await recordPackage('@babylonjs/core', 'babylon', 934);
await recordPackage('babylonjs-core-7', 'babylon_7', 700);
