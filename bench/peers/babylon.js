// Babylon.js's own facet depth sort (mustDepthSortFacets), timed without a graphics card, beside facetsort's sort of
// the same facets from the same eyes in the same run: medians in a table, millions of facets a second.
//
//   npm ci && node babylon.js FACETSORT_BENCH MESH.ply... [--json OUT.json]
//
// OUT.json gets Babylon.js's medians in the form of Google Benchmark, for bench/plot_sort.py.
// FACETSORT_BENCH is the built benchmark program; a mesh it knows is called like its file, and only bunny_70k and
// dragon_871k are in its sort benchmarks. Exits with 1 where an order is wrong.
import { execFileSync } from 'node:child_process';
import { readFileSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { performance } from 'node:perf_hooks';
import { parseArgs } from 'node:util';

import { NullEngine } from '@babylonjs/core/Engines/nullEngine.js';
import { Vector3 } from '@babylonjs/core/Maths/math.vector.js';
import { Mesh } from '@babylonjs/core/Meshes/mesh.js';
import { VertexData } from '@babylonjs/core/Meshes/mesh.vertexData.js';
import { Logger } from '@babylonjs/core/Misc/logger.js';
import { Scene } from '@babylonjs/core/scene.js';

const EYES = 16;
const RADII = 2.5;

// The one form of PLY in which facetsort's meshes are kept: little-endian, three floats a vertex, triangles.
function readMesh(file) {
  const data = readFileSync(file);
  const end = data.indexOf('end_header\n') + 'end_header\n'.length;
  const form = new RegExp(
    '^ply\nformat binary_little_endian 1\\.0\n(?:comment .*\n)*element vertex (\\d+)\n' +
      'property float x\nproperty float y\nproperty float z\nelement face (\\d+)\n' +
      'property list uchar u?int vertex_indices\nend_header\n$',
  );
  const counts = data.toString('latin1', 0, end).match(form);
  if (!counts) throw new Error(`${file}: a PLY of another form than those of this project`);
  const [vertices, facets] = [Number(counts[1]), Number(counts[2])];
  const positions = new Float32Array(3 * vertices);
  const indices = new Uint32Array(3 * facets);
  let at = end;
  for (let i = 0; i < positions.length; ++i, at += 4) positions[i] = data.readFloatLE(at);
  for (let i = 0; i < indices.length; at += 4) {
    if (i % 3 === 0 && data[at++] !== 3) throw new Error(`${file}: facet ${i / 3} is no triangle`);
    indices[i++] = data.readUInt32LE(at);
  }
  return { positions, indices };
}

// The eyes of facetsort-bench: a Fibonacci sphere about the box of the vertices in use.
function eyesAround({ positions, indices }) {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (const vertex of indices) {
    for (let k = 0; k < 3; ++k) {
      low[k] = Math.min(low[k], positions[3 * vertex + k]);
      high[k] = Math.max(high[k], positions[3 * vertex + k]);
    }
  }
  const distance = (RADII * Math.hypot(...high.map((h, k) => h - low[k]))) / 2;
  return Array.from({ length: EYES }, (_, i) => {
    const y = 1 - (2 * i + 1) / EYES;
    const azimuth = i * Math.PI * (3 - Math.sqrt(5));
    const direction = [Math.sin(azimuth) * Math.sqrt(1 - y * y), y, Math.cos(azimuth) * Math.sqrt(1 - y * y)];
    return new Vector3(...direction.map((d, k) => (low[k] + high[k]) / 2 + distance * d));
  });
}

// Every facet once, with its corners, none farther than the one before by Babylon.js's own keys.
function checkOrder(mesh, indices, sorted, eye) {
  const facetOf = new Map();
  const name = (of, facet) => `${of[3 * facet]} ${of[3 * facet + 1]} ${of[3 * facet + 2]}`;
  for (let facet = 0; facet < indices.length / 3; ++facet) {
    const twins = facetOf.get(name(indices, facet));
    if (twins) twins.push(facet);
    else facetOf.set(name(indices, facet), [facet]);
  }
  const centroids = mesh.getFacetLocalPositions();
  let before = Infinity;
  for (let place = 0; place < indices.length / 3; ++place) {
    const facet = facetOf.get(name(sorted, place))?.pop();
    if (facet === undefined) throw new Error('Babylon.js draws a facet that is not there, or one twice');
    const key = Vector3.DistanceSquared(centroids[facet], eye);
    if (!(key <= before)) throw new Error('Babylon.js draws a farther facet after a nearer one');
    before = key;
  }
  if (sorted.length !== indices.length) throw new Error('Babylon.js leaves facets out');
}

function median(values) {
  const sorted = values.toSorted((a, b) => a - b);
  return (sorted[(sorted.length - 1) >> 1] + sorted[sorted.length >> 1]) / 2;
}

// updateFacetData() is what Babylon.js does each frame: it computes facet normals and centroids anew as well, sorts,
// and writes the index buffer. The first frame, which makes its arrays, is not counted.
function timeBabylon({ positions, indices }, eyes) {
  const engine = new NullEngine();
  let sorted;
  engine.updateDynamicIndexBuffer = (_, written) => {
    sorted = written;
  };
  const mesh = new Mesh('mesh', new Scene(engine));
  const data = new VertexData();
  data.positions = positions;
  data.indices = indices;
  data.normals = new Float32Array(positions.length);
  data.applyToMesh(mesh, true);
  mesh.mustDepthSortFacets = true;
  mesh.facetDepthSortFrom = eyes[eyes.length - 1];
  mesh.updateFacetData();
  const milliseconds = eyes.map((eye) => {
    mesh.facetDepthSortFrom = eye;
    const begin = performance.now();
    mesh.updateFacetData();
    return performance.now() - begin;
  });
  checkOrder(mesh, indices, sorted, eyes[eyes.length - 1]);
  engine.dispose();
  return indices.length / 3 / median(milliseconds) / 1e3;
}

// By the threads used: on the mesh as in its file, which is what Babylon.js gets, and in spatial order.
function timeFacetsort(program, file) {
  const name = path.basename(file, '.ply');
  const options = [
    `--benchmark_filter=^sort_indices/centroid_distance/${name}(_as_read)?/`,
    '--benchmark_repetitions=9',
    '--benchmark_report_aggregates_only=true',
    '--benchmark_min_time=0.05',
    '--benchmark_format=json',
  ];
  const env = { ...process.env, FACETSORT_MESH_PATH: path.dirname(path.resolve(file)) };
  const results = JSON.parse(execFileSync(program, options, { env, encoding: 'utf8', maxBuffer: 1 << 26 }));
  return results.benchmarks
    .filter((run) => run.aggregate_name === 'median')
    .map((run) => {
      const [, , variant, threads] = run.run_name.split('/');
      const order = variant === name ? 'spatial order' : 'as read';
      const count = threads.replace('threads:', '');
      return { name: `facetsort, ${order}, ${count} thread(s)`, speed: run.items_per_second / 1e6 };
    });
}

const { values, positionals } = parseArgs({ options: { json: { type: 'string' } }, allowPositionals: true });
const [program, ...files] = positionals;
if (files.length === 0) {
  console.error('usage: node babylon.js FACETSORT_BENCH MESH.ply... [--json OUT.json]');
  process.exit(2);
}
Logger.LogLevels = Logger.ErrorLogLevel;  // else each engine greets on standard output
console.log('| mesh | contender | M facets/s | times Babylon.js |\n|---|---|---|---|');
const benchmarks = [];
for (const file of files) {
  const mesh = readMesh(file);
  const babylon = timeBabylon(mesh, eyesAround(mesh));
  benchmarks.push({
    run_name: `peer_babylon/${path.basename(file, '.ply')}/real_time`,
    run_type: 'aggregate',
    aggregate_name: 'median',
    items_per_second: babylon * 1e6,
  });
  for (const { name, speed } of [{ name: 'Babylon.js', speed: babylon }, ...timeFacetsort(program, file)]) {
    console.log(
      `| ${path.basename(file, '.ply')} | ${name} | ${speed.toPrecision(3)} | ${(speed / babylon).toPrecision(3)} |`,
    );
  }
}
if (values.json) writeFileSync(values.json, JSON.stringify({ benchmarks }));
