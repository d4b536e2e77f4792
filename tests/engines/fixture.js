// The form of fixtures/*.json: one line a scene, and a draw in a few characters.
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';

// "12b" draws item 12's back faces; "f" front faces, "a" all. Then, where it is so:
//   "p" colours are not written    "w" depth is not written    "t" no depth test    "c" depth is cleared before it
//   "k" fragments are tested against the material's alpha cutoff
//   "T" into the texture that transmission reads
export function drawText({ item, faces, noColour, noDepthWrite, noDepthTest, clearsDepth, alphaTest, transmission }) {
  return `${item}${faces}${noColour ? 'p' : ''}${noDepthWrite ? 'w' : ''}${noDepthTest ? 't' : ''}${
    clearsDepth ? 'c' : ''
  }${alphaTest ? 'k' : ''}${transmission ? 'T' : ''}`;
}

export function packageVersion(folder) {
  const description = JSON.parse(readFileSync(new URL(`node_modules/${folder}/package.json`, import.meta.url)));
  return `${description.name} ${description.version}`;
}

// Numbers keep all their bits: JSON.stringify writes the shortest decimals that read back as the same double.
export function writeFixture(name, engine, scenes) {
  const folder = new URL('fixtures/', import.meta.url);
  mkdirSync(folder, { recursive: true });
  const lines = scenes.map((scene) => JSON.stringify(scene)).join(',\n');
  writeFileSync(new URL(`${name}.json`, folder), `{"engine":${JSON.stringify(engine)},"scenes":[\n${lines}\n]}\n`);
  console.log(`${name}: ${scenes.length} scenes of ${engine}`);
}
