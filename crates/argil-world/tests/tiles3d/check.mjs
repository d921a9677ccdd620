// Reads 3D Tiles as a viewer does, from the specification alone, and holds every mesh against Khronos' validator.
// Usage: node check.mjs FOLDER
import assert from "node:assert/strict";
import { existsSync, readFileSync, readdirSync } from "node:fs";
import { join } from "node:path";
import validator from "gltf-validator";

const folder = process.argv[2];
const tileset = JSON.parse(readFileSync(join(folder, "tileset.json"), "utf8"));
assert.equal(tileset.asset.version, "1.1");
const { root } = tileset;
assert.equal(root.refine, "REPLACE");
const { subdivisionScheme, subtreeLevels, availableLevels, subtrees } = root.implicitTiling;
assert.equal(subdivisionScheme, "OCTREE");
const named = (template, [level, x, y, z]) =>
  template.replace("{level}", level).replace("{x}", x).replace("{y}", y).replace("{z}", z);

// One bit for each tile.
const availability = (subtree, about, count) => {
  if (about.constant !== undefined) return Array(count).fill(about.constant === 1);
  const view = subtree.json.bufferViews[about.bitstream];
  assert.equal(view.byteOffset % 8, 0);
  assert.equal(view.byteLength, Math.ceil(count / 8));
  const bytes = subtree.binary.subarray(view.byteOffset, view.byteOffset + view.byteLength);
  const bits = Array.from({ length: count }, (_, i) => ((bytes[i >> 3] >> (i & 7)) & 1) === 1);
  assert.equal(bits.filter(Boolean).length, about.availableCount);
  return bits;
};
const readSubtree = (place) => {
  const path = join(folder, named(subtrees.uri, place));
  const bytes = readFileSync(path);
  assert.equal(bytes.toString("latin1", 0, 4), "subt", path);
  assert.equal(bytes.readUInt32LE(4), 1);
  const [text, binary] = [8, 16].map((at) => Number(bytes.readBigUInt64LE(at)));
  assert.ok(text % 8 === 0 && binary % 8 === 0 && 24 + text + binary === bytes.length, path);
  const subtree = { json: JSON.parse(bytes.toString("utf8", 24, 24 + text)), binary: bytes.subarray(24 + text) };
  if (subtree.json.buffers) assert.equal(subtree.json.buffers[0].byteLength, binary);
  const inner = (8 ** subtreeLevels - 1) / 7;
  return {
    tiles: availability(subtree, subtree.json.tileAvailability, inner),
    contents: availability(subtree, subtree.json.contentAvailability[0], inner),
    children: availability(subtree, subtree.json.childSubtreeAvailability, 8 ** subtreeLevels),
  };
};
const morton = (code, levels) => {
  const place = [0, 0, 0];
  for (let bit = 0; bit < levels; bit++) {
    for (let axis = 0; axis < 3; axis++) place[axis] |= ((code >> (3 * bit + axis)) & 1) << bit;
  }
  return place;
};

// The box of a tile, whose axes are those of the glTF: x, y and z of the octree are x, z and −y of the tileset.
const [center, ...axes] = [0, 3, 6, 9].map((at) => root.boundingVolume.box.slice(at, at + 3));
const half = Math.hypot(...axes[0]);
axes.forEach((axis, nth) => {
  const along = [[1, 0, 0], [0, 0, 1], [0, -1, 0]][nth];
  along.forEach((own, i) => assert.ok(Math.abs(axis[i] - own * half) < 1e-6 * half));
});
const middle = [center[0], center[2], -center[1]];
const boxOf = ([level, ...place]) => {
  const side = (2 * half) / 2 ** level;
  const low = place.map((own, i) => middle[i] - half + own * side);
  return { low, high: low.map((own) => own + side), side };
};

const found = new Set();
let [meshes, triangles, subtreeCount] = [0, 0, 0];
const visit = async (place) => {
  const subtree = readSubtree(place);
  subtreeCount++;
  let first = 0;
  for (let levels = 0; levels < subtreeLevels; first += 8 ** levels++) {
    for (let code = 0; code < 8 ** levels; code++) {
      const isAvailable = subtree.tiles[first + code];
      const hasContent = subtree.contents[first + code];
      assert.ok(isAvailable || !hasContent);
      if (!isAvailable) continue;
      if (levels > 0) assert.ok(subtree.tiles[first - 8 ** (levels - 1) + (code >> 3)], "a tile without the one above");
      const own = [place[0] + levels, ...morton(code, levels).map((c, i) => (place[i + 1] << levels) + c)];
      assert.ok(own[0] < availableLevels);
      if (!hasContent) continue;
      const uri = named(root.content.uri, own);
      found.add(uri);
      const { issues, info } = await validator.validateBytes(new Uint8Array(readFileSync(join(folder, uri))));
      assert.equal(issues.numErrors + issues.numWarnings, 0, `${uri}: ${JSON.stringify(issues.messages.slice(0, 3))}`);
      meshes++;
      triangles += info.totalTriangleCount;
      // Within its box, but for the strips behind its borders.
      const glb = readFileSync(join(folder, uri));
      const gltf = JSON.parse(glb.toString("utf8", 20, 20 + glb.readUInt32LE(12)));
      const box = boxOf(own);
      const more = box.side * (2.1 / 64);
      for (const mesh of gltf.meshes) {
        const { min, max } = gltf.accessors[mesh.primitives[0].attributes.POSITION];
        for (let i = 0; i < 3; i++) {
          assert.ok(min[i] >= box.low[i] - more && max[i] <= box.high[i] + more, `${uri} leaves its box`);
        }
      }
    }
  }
  for (let code = 0; code < 8 ** subtreeLevels; code++) {
    if (!subtree.children[code]) continue;
    await visit([place[0] + subtreeLevels, ...morton(code, subtreeLevels).map((c, i) => (place[i + 1] << subtreeLevels) + c)]);
  }
};
await visit([0, 0, 0, 0]);

// Nothing else lies around.
const all = (path) =>
  readdirSync(join(folder, path), { withFileTypes: true }).flatMap((own) =>
    own.isDirectory() ? all(`${path}/${own.name}`) : [`${path}/${own.name}`],
  );
assert.deepEqual(new Set(all("content")), found);
assert.equal(all("subtrees").length, subtreeCount);
assert.ok(meshes > 10 && existsSync(join(folder, "tileset.json")));
console.log(`  ${meshes} meshes with ${triangles} triangles in ${subtreeCount} subtrees, ${availableLevels} levels`);
