// Checks of what is on the screen, for any page. Returns sentences about what is wrong.
const wrong = [];
const seen = (element) => {
  const box = element.getBoundingClientRect();
  const style = getComputedStyle(element);
  return box.width > 0 && box.height > 0 && style.visibility !== "hidden" && box.right > 0 && box.bottom > 0;
};
const colour = (text) => {
  const parts = /rgba?\(([^)]+)\)/.exec(text)[1].split(/[ ,/]+/).map(Number);
  return { r: parts[0], g: parts[1], b: parts[2], a: parts[3] ?? 1 };
};
const light = ({ r, g, b }) => {
  const part = (v) => ((v /= 255) <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
  return 0.2126 * part(r) + 0.7152 * part(g) + 0.0722 * part(b);
};
const ground = (element) => {
  for (let at = element; at !== null; at = at.parentElement) {
    const found = colour(getComputedStyle(at).backgroundColor);
    if (found.a === 1) return found;
  }
  return { r: 255, g: 255, b: 255 };
};
// WCAG 1.4.3: texts stand out, 4.5 to 1.
const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
while (walker.nextNode()) {
  const text = walker.currentNode.textContent.trim();
  const element = walker.currentNode.parentElement;
  if (text === "" || !seen(element) || element.closest("option, .u-wrap, noscript") !== null) continue;
  const [a, b] = [light(colour(getComputedStyle(element).color)), light(ground(element))].sort((x, y) => y - x);
  const ratio = (a + 0.05) / (b + 0.05);
  if (ratio < 4.5) wrong.push(`contrast ${ratio.toFixed(2)} of "${text.slice(0, 40)}"`);
}
// WCAG 2.5.8: 24 by 24.
for (const element of document.querySelectorAll("button, a.button, nav a, input, select")) {
  const box = element.getBoundingClientRect();
  if (seen(element) && element.type !== "checkbox" && (box.width < 24 || box.height < 24)) wrong.push(`small: ${element.outerHTML.slice(0, 80)}`);
}
// WCAG 1.4.10: nothing beside the screen.
const over = document.documentElement.scrollWidth - innerWidth;
if (over > 0) wrong.push(`${over} px wider than the screen`);
if (document.querySelectorAll("h1").length !== 1) wrong.push("not one h1");
return wrong;
