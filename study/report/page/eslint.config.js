// Faults only: the form is the author's. No plugins, so that eslint alone is needed. PROSE: build.js puts it in.
const globals = ["Blob", "IntersectionObserver", "PROSE", "ResizeObserver", "URL", "URLSearchParams", "addEventListener",
  "clearTimeout", "console", "devicePixelRatio", "document", "fetch", "getComputedStyle", "history", "location",
  "navigator", "performance", "removeEventListener", "requestAnimationFrame", "cancelAnimationFrame", "setTimeout", "window"];
const rules = ["constructor-super", "for-direction", "getter-return", "no-cond-assign", "no-const-assign", "no-dupe-args",
  "no-dupe-class-members", "no-dupe-else-if", "no-dupe-keys", "no-duplicate-case", "no-func-assign", "no-import-assign",
  "no-loss-of-precision", "no-self-assign", "no-self-compare", "no-sparse-arrays", "no-this-before-super", "no-undef",
  "no-unreachable", "no-unsafe-finally", "no-unsafe-negation", "no-unused-vars", "use-isnan", "valid-typeof"];

export default [{
  files: ["src/**/*.js"],
  languageOptions: {globals: Object.fromEntries(globals.map((name) => [name, "readonly"]))},
  rules: Object.fromEntries(rules.map((name) => [name, "error"])),
}];
