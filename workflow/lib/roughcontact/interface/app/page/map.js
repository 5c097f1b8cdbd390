"use strict";
// The map of a row: heights under the cursor and along a line; a rectangle zooms in, or is written into the cell crop or mask.
let start = null, question = new AbortController();
const tool = () => document.querySelector("[name=tool]:checked").value;

// where an event is on the map, µm to the right and downwards, as its picture has them
function position(event) {
  const map = element("map"), { x, y, width, height } = map.viewBox.baseVal;
  const point = new DOMPoint(event.clientX, event.clientY).matrixTransform(map.getScreenCTM().inverse());
  return [Math.min(x + width, Math.max(x, point.x)), Math.min(y + height, Math.max(y, point.y))];
}

async function tell(from, to) {
  question.abort();  // the last one alone is answered
  question = new AbortController();
  const line = [from[0], -from[1], to[0], -to[1]];
  const response = await fetch(`${element("map").dataset.address}?line=${line}`, { signal: question.signal });
  const { words, curve } = await response.json();
  element("cursor").textContent = words;
  if (curve) element("curve").setAttribute("points", curve);
}

document.addEventListener("pointerdown", event => { if (event.target.closest("#map")) start = position(event); });
document.addEventListener("pointermove", event => {
  if (!start && !event.target.closest("#map")) return;
  const here = position(event), [x1, y1] = start ?? here, [x2, y2] = here;
  tell(start && tool() === "line" ? start : here, here).catch(() => {});
  element("outline").setAttribute("points", tool() === "line" ? [x1, y1, x2, y2] : [x1, y1, x2, y1, x2, y2, x1, y2, x1, y1]);
});
document.addEventListener("pointerup", event => {
  if (!start) return;
  const here = position(event), row = element("map").dataset.row;
  const [[left, right], [upper, lower]] = [0, 1].map(axis => [start[axis], here[axis]].sort((a, b) => a - b));
  start = null;
  if (tool() === "line" || left === right || upper === lower) return;
  element("outline").removeAttribute("points");
  if (tool() === "zoom") return ask("look", [[element("box").name, `${left} ${upper} ${right - left} ${lower - upper}`]]);
  const field = element(`rows.${row}.${tool()}`), text = `${[left, -lower, right, -upper].map(side => +side.toPrecision(5)).join(" ")} um`;
  field.value = tool() === "mask" && field.value ? `${field.value}; ${text}` : text;
  field.dispatchEvent(new Event("input", { bubbles: true }));
});
