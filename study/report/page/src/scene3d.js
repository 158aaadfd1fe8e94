export function mountScene(element, view) { element.textContent = "no scene yet"; }
