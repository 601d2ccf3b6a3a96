// Bundles the pages and writes them as C++: node build.mjs OUT.cpp, in a folder with src/, client/ and node_modules/.
// Names of all files but index.html carry a hash of their contents, so that browsers may keep them for ever.
import { build } from "esbuild";
import { createHash } from "node:crypto";
import { readFileSync, writeFileSync } from "node:fs";
import { gzipSync } from "node:zlib";

const out = process.argv[2];
const types = { css: "text/css; charset=utf-8", html: "text/html; charset=utf-8", js: "text/javascript; charset=utf-8", svg: "image/svg+xml" };
const hash = (bytes) => createHash("sha256").update(bytes).digest("hex").slice(0, 16);

const bundle = await build({
  entryPoints: ["src/main.tsx"],
  bundle: true,
  minify: true,
  format: "esm",
  target: ["es2020", "chrome90", "firefox90", "safari15"],
  jsx: "automatic",
  jsxImportSource: "preact",
  preserveSymlinks: true,
  charset: "utf8",
  legalComments: "none",
  outdir: "bundle",
  write: false,
});

const files = [];
const add = (name, extension, bytes) => {
  const path = name === "" ? "/" : `/${name}-${hash(bytes)}.${extension}`;
  files.push({ path, type: types[extension], tag: hash(bytes), bytes });
  return path;
};
const bundled = (extension) => Buffer.from(bundle.outputFiles.find((file) => file.path.endsWith(`.${extension}`)).contents);
const links = {
  script: add("app", "js", bundled("js")),
  style: add("app", "css", bundled("css")),
  icon: add("icon", "svg", readFileSync("src/icon.svg")),
};
// What others wrote is in the bundle, and their licences want to be told.
const parts = Object.keys(JSON.parse(readFileSync("package.json", "utf8")).dependencies);
const licences = parts.map((name) => `${name}\n\n${readFileSync(`node_modules/${name}/LICENSE`, "utf8").trim()}\n`).join(`\n${"-".repeat(72)}\n\n`);
files.push({ path: "/licences.txt", type: "text/plain; charset=utf-8", tag: hash(licences), bytes: Buffer.from(licences) });
const index = readFileSync("src/index.html", "utf8").replace(/\{(\w+)\}/g, (_, name) => links[name]);
add("", "html", Buffer.from(index));

let text = '// Made by web/build.mjs.\n#include "web/files.h"\n\nnamespace plc::web {\nnamespace {\n';
let rows = "";
let total = 0;
files.forEach((file, i) => {
  const packed = gzipSync(file.bytes, { level: 9 });
  // The system that packs is written into the bytes: the same everywhere.
  packed[9] = 255;
  total += packed.length;
  text += `constexpr unsigned char k${i}[] = {${[...packed].join(",")}};\n`;
  rows += `    {"${file.path}", "${file.type}", "\\"${file.tag}\\"", ${file.path.includes(file.tag)}, k${i}},\n`;
});
text += `constexpr engineering::PageFile kFiles[] = {\n${rows}};\n}  // namespace\n`;
text += "std::span<const engineering::PageFile> files() { return kFiles; }\n}  // namespace plc::web\n";
writeFileSync(out, text);
const most = 100_000;
console.log(`pages: ${total} bytes, compressed`);
if (total > most) {
  console.error(`error: the pages have more than ${most} bytes`);
  process.exit(1);
}
