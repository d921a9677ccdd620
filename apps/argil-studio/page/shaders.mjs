// Compiles shaders in Chromium: `node shaders.mjs CHROMIUM FILE`, where the file lists modules with a name and a source.
import { readFileSync } from "node:fs";
import { createServer } from "node:http";
import { launch } from "./browser.mjs";

const [executablePath, file] = process.argv.slice(2);
const modules = JSON.parse(readFileSync(file));
const browser = await launch(executablePath);
// WebGPU is only there for pages of a server.
const server = createServer((_, response) => response.end("shaders"));
await new Promise((ready) => server.listen(0, "127.0.0.1", ready));
const page = await browser.newPage();
await page.goto(`http://127.0.0.1:${server.address().port}/`);
const faults = await page.evaluate(async (all) => {
  const adapter = await navigator.gpu.requestAdapter();
  const device = await adapter.requestDevice({ requiredFeatures: [...adapter.features] });
  const faults = [];
  for (const { name, source } of all) {
    device.pushErrorScope("validation");
    // naga knows subgroups without being told.
    const head = source.includes("subgroup") ? "enable subgroups; diagnostic(off, subgroup_uniformity); " : "";
    const { messages } = await device.createShaderModule({ code: head + source }).getCompilationInfo();
    await device.popErrorScope();
    const errors = messages.filter(({ type }) => type === "error");
    faults.push(...errors.map(({ lineNum, message }) => `${name}:${lineNum}: ${message}`));
  }
  return faults;
}, modules);
await browser.close();
server.close();
console.log([`  ${modules.length} shaders`, ...faults].join("\n"));
process.exit(faults.length ? 1 : 0);
