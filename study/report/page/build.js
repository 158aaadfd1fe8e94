// Makes page.html: `npm ci && npm run build`. With --check it compares instead, and fails where page.html is stale.
import { createHash } from "node:crypto";
import { readFileSync, readdirSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import esbuild from "esbuild";
import { marked } from "marked";

const folder = dirname(fileURLToPath(import.meta.url));
const source = (...names) => join(folder, "src", ...names);

/** The prose as HTML: src/prose/limits.md is PROSE.limits in the modules. */
const prose = Object.fromEntries(readdirSync(source("prose")).sort().map((file) =>
  [file.replace(/\.md$/, ""), marked.parse(readFileSync(source("prose", file), "utf8"))]));

const options = { bundle: true, minify: true, write: false, charset: "utf8", legalComments: "none", target: "es2021" };
const [script] = (await esbuild.build({
  ...options, entryPoints: [source("main.js")], format: "iife", define: { PROSE: JSON.stringify(prose) },
})).outputFiles;
const [style] = (await esbuild.build({ ...options, entryPoints: [source("page.css")] })).outputFiles;

// The browser itself refuses every request, and every script but this one: what the page shows is in the page.
const code = script.text.trim();
const hash = createHash("sha256").update(code).digest("base64");
const policy = `default-src 'none'; script-src 'sha256-${hash}'; style-src 'unsafe-inline'; img-src data: blob:`;
const page = `<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<!-- Made by build.js from the files in src/: do not edit. It holds d3 and Observable Plot (ISC) and three.js (MIT). -->
<meta http-equiv="Content-Security-Policy" content="${policy}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<title>lcpbench</title>
<style>${style.text.trim()}</style>
</head>
<body>
<noscript>This page needs JavaScript. The folder tables/ that lcpbench report writes holds its numbers as CSV files.</noscript>
<script type="application/json" id="report">@report@</script>
<script>${code}</script>
</body>
</html>
`;
if (page.split("@report@").length !== 2) throw new Error("@report@ must stand in the page once");

const target = join(folder, "page.html");
if (!process.argv.includes("--check")) writeFileSync(target, page);
else if (readFileSync(target, "utf8") !== page) {
  console.error("page.html is not what src/ makes: run `npm ci && npm run build` in study/report/page");
  process.exit(1);
}
