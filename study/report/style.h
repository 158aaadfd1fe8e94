#pragma once

namespace lcpbench::report {

/// The report's style sheet. Light and dark follow the reader's system, kFigureStyle does the same for pictures. What
/// is folded stays folded in print.
inline constexpr const char* kStyle = R"css(
:root { color-scheme: light dark; --ink: #1d1f21; --soft: #5b6066; --ground: #ffffff; --panel: #f5f6f7;
  --line: #d9dcdf; --link: #1f5a99; --bad: #b3261e; --good: #1b6e3c; }
@media (prefers-color-scheme: dark) { :root { --ink: #e6e7e8; --soft: #a8adb3; --ground: #17191b; --panel: #212427;
  --line: #3a3e43; --link: #86b7ea; --bad: #ff8a80; --good: #7fd1a0; } }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 1360px; padding: 1rem 1.25rem 4rem; background: var(--ground); color: var(--ink);
  font: 16px/1.5 system-ui, "Segoe UI", Helvetica, Arial, sans-serif; }
h1 { font-size: 1.6rem; line-height: 1.25; margin: .6rem 0 .4rem; }
h2 { font-size: 1.3rem; margin: 2.4rem 0 .5rem; padding-top: .6rem; border-top: 1px solid var(--line); }
h3 { font-size: 1.05rem; margin: 1.8rem 0 .4rem; overflow-wrap: anywhere; }
p, ul, ol, dl, summary { max-width: 75ch; margin: .5rem 0; }
.answer { font-size: 1.12rem; max-width: 75ch; }
.caught { max-width: 75ch; font-size: .92rem; }
.caught code { color: var(--bad); }
.alarm { border: 2px solid var(--bad); border-radius: 6px; padding: .1rem .9rem; margin: .6rem 0; max-width: 75ch; }
.alarm strong { color: var(--bad); font-size: 1.2rem; }
.note { color: var(--soft); font-size: .88rem; }
a { color: var(--link); }
code { font: .875em ui-monospace, "DejaVu Sans Mono", Menlo, Consolas, monospace; overflow-wrap: anywhere; }
nav { font-size: .92rem; margin: 0 0 .4rem; }
nav a { margin-right: .9rem; display: inline-block; }
.scroll { overflow-x: auto; border: 1px solid var(--line); border-radius: 6px; margin: .6rem 0; max-width: 100%; }
table { border-collapse: separate; border-spacing: 0; width: 100%; font-size: .88rem;
  font-variant-numeric: tabular-nums; }
caption { text-align: left; padding: .4rem .6rem; color: var(--soft); }
th, td { padding: .35rem .5rem; text-align: left; vertical-align: top; border-bottom: 1px solid var(--line); }
tr:last-child > * { border-bottom: 0; }
thead th { background: var(--panel); font-weight: 600; vertical-align: bottom; }
td.number, th.number, td[data-value] { text-align: right; }
td.number, td[data-value], th.line { white-space: nowrap; }
summary { cursor: pointer; margin: .5rem 0; }
#reference select { font: inherit; max-width: 100%; }
tbody th { font-weight: 400; }
.cells code, .paper code { white-space: nowrap; }
.overview td code, .overview th code { white-space: normal; }
@media (min-width: 800px) { .cells tbody th, .cases tbody th { position: sticky; left: 0; background: var(--ground); } }
.cases code { white-space: nowrap; }
.cases thead th + th { writing-mode: vertical-rl; transform: rotate(180deg); vertical-align: top; padding: .5rem .2rem; }
.cases td { padding: .35rem .2rem; text-align: center; white-space: nowrap; }
.cases tbody th { min-width: 17rem; }
.paper .words { min-width: 13rem; }
small { color: var(--soft); font-size: .82rem; }
td small, th small { display: block; }
.bad { color: var(--bad); font-weight: 600; }
.good { color: var(--good); }
.zero { color: var(--soft); }
.decision td.reasons { min-width: 21rem; }
.decision ul { margin: 0; padding-left: 1.1rem; }
.decision td.use > code { font-weight: 600; }
.decision tbody th { font-weight: 600; min-width: 9rem; }
.decision tbody th small { font-weight: 400; }
.decision div small { display: inline; white-space: nowrap; }
.decision td { min-width: 9.5rem; }
th button { font: inherit; font-weight: 600; color: inherit; background: none; border: 0; padding: 0; cursor: pointer;
  text-align: inherit; }
th button::after { content: "\a0\2195"; color: var(--soft); font-weight: 400; }
th[aria-sort=ascending] button::after { content: "\a0\2191"; }
th[aria-sort=descending] button::after { content: "\a0\2193"; }
figure { margin: .8rem 0; }
figure svg { display: block; width: 100%; min-width: 640px; max-width: 900px; height: auto; margin: 0 auto; }
.gallery { display: grid; grid-template-columns: repeat(auto-fill, minmax(14rem, 1fr)); gap: .4rem .8rem; align-items: end; }
.gallery figure { margin: 0; } .gallery figure svg { min-width: 0; max-width: 300px; margin: 0; overflow: hidden; }
.gallery small { display: block; }
.film { display: grid; grid-template-columns: repeat(6, minmax(0, 1fr)); gap: .3rem; max-width: 1100px; }
.film figure { margin: 0; } .film figure svg { min-width: 0; width: 100%; overflow: hidden; }
.matrices { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 36rem), 1fr)); gap: .6rem 1.2rem; }
.matrices > * { min-width: 0; }
.matrices table { font-size: .84rem; }
.matrices th, .matrices td { padding: .3rem .35rem; }
@media (max-width: 600px) {
  .decision, .decision tbody, .decision tr, .decision td, .decision tbody th { display: block; }
  .decision thead { display: none; }
  .decision tr { border-bottom: 1px solid var(--line); padding: .4rem 0; }
  .decision tr:last-child { border-bottom: 0; }
  .decision td, .decision tbody th { border-bottom: 0; padding: .2rem .6rem; }
  .decision td[data-label]::before { content: attr(data-label); display: block; color: var(--soft); font-size: .82rem; }
  body { padding: .6rem .8rem 3rem; } h1 { font-size: 1.3rem; } .answer { font-size: 1.02rem; } }
@media print { body { max-width: none; font-size: 9.5pt; padding: 0; } nav, #reference { display: none; }
  .scroll { overflow: visible; border: 0; } table { font-size: 7.5pt; } th, td { padding: 1.5pt 3pt; }
  .cells code, td.number, td[data-value] { white-space: normal; } h2 { margin-top: 1rem; }
  details > summary { list-style: none; color: var(--soft); font-size: 8pt; margin: .1rem 0; }
  .decision td.reasons { min-width: 0; } .decision td, .decision tbody th { min-width: 0; }
  tr, figure { break-inside: avoid; } figure svg { min-width: 0; } th button::after { content: ""; } }
)css";

/// Three comforts; without the script the page says the same. The tables of class "cells" become sortable by their
/// headings. A link to a folded part opens it. The reader's choice of a reference rewrites the factors.
inline constexpr const char* kScript = R"js(
for (const table of document.querySelectorAll('table.cells')) {
  const body = table.tBodies[0];
  table.tHead.querySelectorAll('th').forEach((heading, column) => {
    const button = document.createElement('button');
    button.type = 'button';
    button.append(...heading.childNodes);
    heading.append(button);
    button.addEventListener('click', () => {
      const ascending = heading.getAttribute('aria-sort') !== 'ascending';
      const key = row => row.cells[column]?.dataset.value ?? row.cells[column]?.textContent ?? '';
      const compare = (a, b) => {
        const x = parseFloat(key(a)), y = parseFloat(key(b));
        if (Number.isNaN(x) && Number.isNaN(y)) return key(a).localeCompare(key(b));
        if (Number.isNaN(x) || Number.isNaN(y)) return Number.isNaN(x) ? 1 : -1;
        return ascending ? x - y : y - x;
      };
      body.append(...[...body.rows].sort(compare));
      table.tHead.querySelectorAll('th').forEach(other => other.removeAttribute('aria-sort'));
      heading.setAttribute('aria-sort', ascending ? 'ascending' : 'descending');
    });
  });
}

const reveal = () => {
  let part = document.getElementById(decodeURIComponent(location.hash.slice(1)));
  for (; part; part = part.parentElement) if (part.tagName === 'DETAILS') part.open = true;
};
addEventListener('hashchange', reveal);
reveal();

const data = JSON.parse(document.getElementById('factors').textContent);
const factorOver = (place, reference) => {
  const [key, solver] = place.split(':');
  const set = data.by_set[key];
  if (!set) return 0;
  const i = set.of.indexOf(Number(solver)), j = set.of.indexOf(reference);
  if (i < 0 || j < 0) return 0;
  if (i === j) return 1;
  return i < j ? set.factors[i][j - i - 1] : 1 / (set.factors[j]?.[i - j - 1] || Infinity);
};
const number = x => x < 1 ? String(+x.toPrecision(2)) : x < 9.995 ? x.toFixed(2) : x < 99.95 ? x.toFixed(1)
  : x < 999.5 ? x.toFixed(0) : String(+x.toPrecision(3));
const speed = (x, name) => !x ? 'no factor: too few problems solved by both it and ' + name
  : x > 1 / 1.05 && x < 1.05 ? 'in the same time as ' + name
  : (x < 1 ? number(1 / x) + '× faster than ' : number(x) + '× slower than ') + name;
const choice = document.getElementById('reference');
if (choice) {
  choice.hidden = false;
  const places = document.querySelectorAll('[data-factor], [data-speed]');
  places.forEach(place => { place.printed = [place.innerHTML, place.dataset.value]; });
  choice.querySelector('select').addEventListener('change', event => {
    const chosen = event.target.value, name = data.solvers[chosen];
    places.forEach(place => {
      const key = place.dataset.factor ?? place.dataset.speed;
      const x = chosen === '' ? 0 : factorOver(key, Number(chosen));
      if (chosen === '') {
        [place.innerHTML, place.dataset.value] = place.printed;
      } else if (place.dataset.speed) {
        place.textContent = speed(x, name);
      } else {
        place.textContent = x ? number(x) : '–';
        place.title = 'over ' + name;
        place.dataset.value = x || '';
      }
    });
  });
}
)js";

}  // namespace lcpbench::report
