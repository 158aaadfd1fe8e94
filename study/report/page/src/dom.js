// Elements from data. Text becomes text nodes: nothing that a store holds is ever read as HTML.

/** h("a", {href: "#x", class: "y", onclick: f}, "text", child, [more]) */
export function h(tag, attributes, ...children) {
  const element = document.createElement(tag);
  setAttributes(element, attributes ?? {});
  append(element, children);
  return element;
}

/** Attributes, and what begins with "on" as listeners; null, undefined and false are left out. @returns the element */
export function setAttributes(element, attributes) {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else element.setAttribute(name, value === true ? "" : value);
  }
  return element;
}

const smallNumber = /(\d(?:\.\d+)?e-\d+)/;

/** Browsers break a line behind any hyphen: a number such as 5.4e-2 becomes an element that stays whole. */
function append(element, children) {
  for (const child of children) {
    if (Array.isArray(child)) append(element, child);
    else if (typeof child === "string" && smallNumber.test(child) && element.tagName !== "OPTION") {
      const whole = (text) => setAttributes(document.createElement("span"), { class: "whole" }).appendChild(
        document.createTextNode(text)).parentNode;
      element.append(...child.split(smallNumber).map((part, i) => (i % 2 ? whole(part) : part)));
    }
    else if (child !== null && child !== undefined && child !== false) element.append(child);
  }
}

/** A solver's or set's name, which may break after a brace or comma. */
export function code(text) {
  const parts = String(text).split(/(?<=[{,/])/);
  return h("code", null, parts.flatMap((part, i) => (i === 0 ? [part] : [h("wbr"), part])));
}

export const small = (...children) => h("small", null, children);

/** The page's own prose, PROSE, which build.js rendered: the one place where HTML is read. {x} in it is a number,
 *  {x_percent} a share in percent. */
export function prose(html, numbers = {}) {
  const template = document.createElement("template");
  template.innerHTML = html.replace(/\{(\w+?)(_percent)?\}/g, (_, name, percent) =>
    String(percent ? Math.round(1e4 * numbers[name]) / 100 : Number(numbers[name])));
  return template.content;
}

/** A fold whose content is made when it is first opened. */
export function fold(summary, make, attributes) {
  const details = h("details", attributes, h("summary", null, summary));
  const fill = () => {
    if (details.open && details.children.length === 1) append(details, [make()].flat());
  };
  details.addEventListener("toggle", fill);
  fill();
  return details;
}

/** A button that copies a text, and says so. */
export function copyButton(text, label = "Copy") {
  const button = h("button", { type: "button", class: "copy", "aria-label": `${label}: ${text}`, onclick: async () => {
    try {
      await navigator.clipboard.writeText(text);
      button.textContent = "Copied";
    } catch {  // a page read from a file has no clipboard in some browsers
      button.textContent = "Select it by hand";
    }
    setTimeout(() => (button.textContent = label), 2000);
  } }, label);
  return button;
}

export function download(name, type, text) {
  const url = URL.createObjectURL(new Blob([text], { type }));
  h("a", { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), 1000);
}
