// Drives the page in Chromium as a person would: `node test.mjs URL CHROMIUM [FOLDER FOR PICTURES]`.
import assert from "node:assert/strict";
import { createReadStream, mkdirSync, readFileSync, statSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import { launch } from "./browser.mjs";

const [url, executablePath, pictures, world] = process.argv.slice(2);
const browser = await launch(executablePath);
const context = await browser.newContext({ viewport: { width: 800, height: 560 }, acceptDownloads: true });
// A machine without a GPU, with other work, takes its time.
context.setDefaultTimeout(180_000);
const page = await context.newPage();
const complaints = [];
page.on("pageerror", (error) => complaints.push(String(error)));
page.on("console", (message) => {
  // Where a world has no more edits, there is nothing.
  const isEnd = message.location().url.includes("/edits/");
  if (message.type() === "error" && !isEnd) complaints.push(message.text());
});

const pause = (ms) => new Promise((done) => setTimeout(done, ms));
// Try until it holds.
const until = async (what, check, seconds = 300) => {
  const end = Date.now() + 1000 * seconds;
  for (;;) {
    const found = await check();
    if (found) return found;
    if (Date.now() >= end) {
      const told = await page.evaluate(() => document.getElementById("told").innerText);
      assert.fail(`${what} did not come about; the page says: ${[told, ...complaints].join("\n")}`);
    }
    await pause(100);
  }
};
// Nothing is asked of the page while it draws: without a GPU that takes it seconds.
const settled = async () => {
  const ask = () => page.evaluate(() => globalThis.argil?.is_settled() ?? false);
  await pause(250);
  await until("a picture at rest", ask);
};
const fault = () => page.evaluate(() => globalThis.argil.fault());
const placeOf = (label) => page.evaluate((l) => globalThis.argil?.widget_rect(l)?.join(), label);
const middleOf = async (label) => {
  const found = await until(`“${label}”`, () => placeOf(label));
  const [x, y, width, height] = found.split(",").map(Number);
  return { x: x + width / 2, y: y + height / 2, width, height };
};
const clickNow = async (label) => {
  const { x, y } = await middleOf(label);
  await page.mouse.move(x, y);
  await pause(150);
  await page.mouse.click(x, y, { delay: 100 });
  await pause(150);
};
const click = async (label) => {
  await settled();
  await clickNow(label);
};
// Light takes a software GPU ten times as long as normals, in pictures that are not about light.
const loaded = async () => {
  await middleOf("Viewport");
  await clickNow("Normal");
};
const drag = async (from, to) => {
  await settled();
  await page.mouse.move(from.x, from.y);
  await pause(200);
  await page.mouse.down();
  await pause(100);
  for (let i = 1; i <= 8; i++) {
    await page.mouse.move(from.x + ((to.x - from.x) * i) / 8, from.y + ((to.y - from.y) * i) / 8);
    // Long enough once for the page to keep the scene, which it is not to do within a stroke.
    await pause(i === 4 ? 800 : 60);
  }
  await page.mouse.up();
  await page.mouse.move(2, 2);
};
const press = async (keys) => {
  await settled();
  await page.keyboard.press(keys, { delay: 150 });
};
const kept = () => page.evaluate(() => localStorage.getItem("argil-scene"));
const entries = async () => JSON.parse((await kept()) ?? "{}").brushes ?? [];
// The picture without the readings over it, in full.
const picture = async () => {
  await settled();
  assert.equal(await fault(), "");
  const { x, y, width, height } = await middleOf("Viewport");
  const clip = { x: x - width / 4, y: y - height / 4, width: width / 2, height: height / 2 };
  return page.screenshot({ clip });
};
const show = async (name) => {
  if (!pictures) return;
  mkdirSync(pictures, { recursive: true });
  await page.screenshot({ path: `${pictures}/${name}.png` });
};
const download = async (menu, item) => {
  const waiting = page.waitForEvent("download", { timeout: 180_000 });
  await click(menu);
  await click(item);
  const file = await waiting;
  return { name: file.suggestedFilename(), bytes: readFileSync(await file.path()) };
};
let begun = Date.now();
const step = (what) => {
  console.log(`  ${what}: ${((Date.now() - begun) / 1000).toFixed(0)} s`);
  begun = Date.now();
};

await page.goto(url);
await middleOf("Viewport");
const first = await picture();
await show("page");
step("opened, and drew a scene");

await click("Normal");
await click("File");
await click("New");
await until("an empty scene", async () => (await kept()) && (await entries()).length === 0);
const empty = await picture();
assert.ok(!empty.equals(first), "the empty scene looks like the one before");
await click("Add Sphere");
await until("a brush", async () => (await entries()).length === 1);
const added = await picture();
assert.ok(!added.equals(empty), "the brush is not drawn");
step("added a brush");

const [before] = await entries();
await click("Move");
const middle = await middleOf("Viewport");
await drag(middle, { x: middle.x + 90, y: middle.y + 25 });
await until("a moved brush", async () => JSON.stringify(await entries()) !== JSON.stringify([before]));
const [moved] = await entries();
assert.equal(moved.shape.type, "sphere");
const there = await picture();
assert.ok(!there.equals(added), "the brush is drawn where it was");
step("dragged it");

await press("Control+z");
await until("the brush where it was", async () => JSON.stringify(await entries()) === JSON.stringify([before]));
await press("Control+Shift+z");
await until("the drag again", async () => JSON.stringify(await entries()) === JSON.stringify([moved]));
step("undid it, and did it again");

await press("Tab");
const spoken = () => page.evaluate(() => document.getElementById("spoken").textContent);
await until("what the keyboard is at", async () => /, \w+/.test(await spoken()));
step(`had it said what the keyboard is at: ${await spoken()}`);

const scene = await download("File", "Save as…");
assert.deepEqual(JSON.parse(scene.bytes).brushes, [moved]);
const mesh = await download("File", "Export mesh…");
assert.match(mesh.name, /\.glb$/);
assert.equal(mesh.bytes.toString("latin1", 0, 4), "glTF");
assert.equal(mesh.bytes.readUInt32LE(8), mesh.bytes.length);
const png = await download("File", "Export image…");
assert.match(png.name, /\.png$/);
assert.equal(png.bytes.toString("latin1", 1, 4), "PNG");
assert.deepEqual([png.bytes.readUInt32BE(16), png.bytes.readUInt32BE(20)], [1920, 1080]);
step("exported the scene, a mesh and a picture");

// What the pipelines draw is nearly the same; what they say is not.
await click("Shaded");
for (const pipeline of ["Field", "Dense", "Octree", "Mesh", "Bricks", "Levels"]) {
  await click(pipeline);
  await picture();
}
step("drew it by all five pipelines");

await page.reload();
await loaded();
assert.deepEqual(await entries(), [moved]);
const again = await picture();
assert.ok(!again.equals(empty), "nothing is drawn after the page was loaded again");
assert.deepEqual(await entries(), [moved]);
step("found it again after loading the page anew");

const told = () => page.evaluate(() => globalThis.argil?.message() ?? "");
const choose = async (item, file) => {
  const choosing = page.waitForEvent("filechooser");
  await click("File");
  await click(item);
  await (await choosing).setFiles(file);
};
const corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]].map((v) => `v ${v.join(" ")}`);
const faces = ["1 3 2", "1 2 4", "1 4 3", "2 3 4"].map((f) => `f ${f}`);
const obj = Buffer.from([...corners, ...faces].join("\n"));
await choose("Import mesh or volume…", { name: "tetra.obj", mimeType: "model/obj", buffer: obj });
await until("the mesh", async () => (await entries()).length === 2);
const withMesh = await entries();
assert.equal(withMesh[1].shape.path, "tetra.obj");
await page.reload();
await loaded();
await settled();
assert.deepEqual(await entries(), withMesh);
assert.equal(await told(), "", "the mesh was kept too");
await click("File");
await click("New");
await click("Cancel");
assert.deepEqual(await entries(), withMesh, "what is saved nowhere is not put away unasked");
await choose("Import mesh or volume…", { name: "flat.obj", mimeType: "model/obj", buffer: Buffer.from("v 0 0 nan\nf 1 1 1") });
await until("a word on the file", async () => /flat\.obj/.test(await told()));
assert.deepEqual(await entries(), withMesh);
step("imported a mesh, kept it, and refused one that is none");

await click("tetra");
await click("Mesh resolution");
await click("32 samples");
await until("a coarser mesh", async () => (await entries())[1].shape.resolution === 32);
await settled();
assert.equal(await fault(), "");
step("sampled it anew, from what the browser keeps");

const ball = { ...moved, name: "Ball" };
const text = JSON.stringify({ argil: 1, brushes: [ball, before] });
const opened = choose("Open…", { name: "two.json", mimeType: "application/json", buffer: Buffer.from(text) });
await opened;
await click("Do not save");
await until("the file's brushes", async () => (await entries())[0]?.name === "Ball");
step("opened a file");

await page.evaluate(() => localStorage.setItem("argil-scene", '{"argil":1,"brushes":[{'));
await page.reload();
await loaded();
await until("a word on what was kept", async () => /the scene that the browser stored/.test(await told()));
assert.match(await page.evaluate(() => localStorage.getItem("argil-scene-unreadable")), /^\{"argil"/);
step("said so where what was kept cannot be read");

// A world on another server: files, ranges, and leave to read them.
const answers = { 200: 0, 206: 0, 404: 0, bytes: 0 };
const server = createServer((request, response) => {
  const path = world + new URL(request.url, "http://host").pathname;
  const headers = { "Access-Control-Allow-Origin": "*" };
  const size = statSync(path, { throwIfNoEntry: false })?.size;
  const range = /^bytes=(\d+)-(\d+)$/.exec(request.headers.range ?? "");
  const status = size === undefined ? 404 : range ? 206 : 200;
  answers[status]++;
  if (status === 404) return response.writeHead(404, headers).end();
  const [start, end] = range ? [Number(range[1]), Math.min(Number(range[2]), size - 1)] : [0, size - 1];
  answers.bytes += end - start + 1;
  response.writeHead(status, { ...headers, "Content-Length": end - start + 1 });
  createReadStream(path, { start, end }).pipe(response);
});
await new Promise((done) => server.listen(0, "127.0.0.1", done));
const address = `http://127.0.0.1:${server.address().port}`;
await page.goto(`${url}?world=${address}`);
await loaded();
await until("a world", async () => (await told()) === `Opened ${address}`);
const streamed = await picture();
await show("world");
assert.equal(await fault(), "");
assert.ok(answers[206] > 10, JSON.stringify(answers));
await click("Add Sphere");
const withSphere = await picture();
assert.ok(!withSphere.equals(streamed), "the sphere is not drawn");
const edits = await download("File", "Save");
assert.equal(edits.name, "edits.jsonl");
assert.match(edits.bytes.toString(), /"insert"/);
mkdirSync(`${world}/edits`);
writeFileSync(`${world}/edits/000001.jsonl`, edits.bytes);
await page.reload();
await loaded();
await until("the world again", async () => (await told()) === `Opened ${address}`);
await until("the saved brush", () => placeOf("Sphere"));
await picture();
await show("world-edited");
assert.equal(await fault(), "");
await page.goto(`${url}?world=${address}/none`);
await until("a word on what is no world", async () => /no manifest\.json/.test(await told()));
complaints.splice(0, complaints.length, ...complaints.filter((text) => !/404/.test(text)));
server.close();
step(`streamed a world from another server in ${answers[206]} ranges, ${(answers.bytes * 1e-6).toFixed(1)} MB, and saved an edit`);

const bare = await context.newPage();
await bare.addInitScript(() => Object.defineProperty(navigator, "gpu", { value: undefined }));
await bare.goto(url);
await bare.getByText("This browser does not support WebGPU.").waitFor();
step("said so where there is no WebGPU");

assert.deepEqual(complaints, []);
await browser.close();
