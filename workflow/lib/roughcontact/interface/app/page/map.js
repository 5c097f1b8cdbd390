"use strict";
// The map of a row: cursor, zoom, a cut along a line; a rectangle that is drawn is written into the cell crop or mask.
const VIRIDIS = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]], MISSING = [255, 79, 163];
let view = null, start = null;
const micrometres = length => `${+(length * 1e6).toPrecision(4)} µm`;

async function look() {
  const viewer = element("viewer");
  if (!viewer?.dataset.key) return;
  const map = `heights/${viewer.dataset.row}?key=${viewer.dataset.key}`;
  if (view?.map !== map) await show(map, "");
  else draw();
}

async function show(map, box) {
  const response = await fetch(`${map}&box=${box}`);
  if (!response.ok) return void (element("cursor").textContent = await response.text());
  view = { map, ...JSON.parse(response.headers.get("facts")), heights: new Float32Array(await response.arrayBuffer()) };
  const { shape: [ny, nx], limits: [low, high], heights } = view, image = new ImageData(nx, ny);
  heights.forEach((height, index) => {
    const level = 4 * Math.min(1, Math.max(0, (height - low) / (high - low || 1))), step = Math.min(3, Math.floor(level));
    const colour = isNaN(height) ? MISSING : VIRIDIS[step].map((part, k) => part + (level - step) * (VIRIDIS[step + 1][k] - part));
    image.data.set([...colour, 255], 4 * ((ny - 1 - Math.floor(index / nx)) * nx + index % nx));
  });
  view.picture = await createImageBitmap(image);
  draw();
}

function draw(tool, here) {
  const canvas = element("map"), [left, lower, right, upper] = view.sides;
  canvas.height = Math.min(960, Math.max(60, canvas.width * (upper - lower) / (right - left)));
  const pen = canvas.getContext("2d"), { crop, mask } = JSON.parse(element("viewer").dataset.rectangles);
  const x = length => (length - left) / (right - left) * canvas.width, y = length => (upper - length) / (upper - lower) * canvas.height;
  const box = ([x1, y1, x2, y2]) => [x(x1), y(y1), x(x2) - x(x1), y(y2) - y(y1)];
  pen.imageSmoothingEnabled = false;
  pen.drawImage(view.picture, 0, 0, canvas.width, canvas.height);
  Object.assign(pen, { lineWidth: 2, strokeStyle: "#e08a00", fillStyle: "#ff4fa3" });
  for (const rectangle of mask) pen.fillRect(...box(rectangle));
  for (const rectangle of crop) pen.strokeRect(...box(rectangle));
  pen.setLineDash([6, 4]);
  if (tool === "line") { pen.beginPath(); pen.moveTo(x(start[0]), y(start[1])); pen.lineTo(x(here[0]), y(here[1])); pen.stroke(); cut(here); }
  else if (tool) pen.strokeRect(...box([...start, ...here]));
}

function height([x, y]) {
  const { sides: [left, lower, right, upper], shape: [ny, nx], heights } = view;
  const index = (position, first, last, count) => Math.min(count - 1, Math.max(0, Math.floor((position - first) / (last - first) * count)));
  return heights[index(y, lower, upper, ny) * nx + index(x, left, right, nx)];
}

function cut(here) {
  const canvas = element("cut"), pen = canvas.getContext("2d"), along = n => start.map((from, k) => from + (here[k] - from) * n / 319);
  const cuts = [...Array(320).keys()].map(n => height(along(n))), known = cuts.filter(value => !isNaN(value));
  const low = Math.min(...known), high = Math.max(...known);
  pen.clearRect(0, 0, canvas.width, canvas.height);
  pen.beginPath();
  cuts.forEach((value, n) => isNaN(value) ? 0 : pen.lineTo(2 * n, 150 - 140 * (value - low) / (high - low || 1)));
  pen.stroke();
  element("cursor").textContent = `${micrometres(Math.hypot(here[0] - start[0], here[1] - start[1]))} along the line, heights over ${micrometres(high - low)}`;
}

function position(event) {
  const frame = element("map").getBoundingClientRect(), [left, lower, right, upper] = view.sides, within = share => Math.min(1, Math.max(0, share));
  return [left + within((event.clientX - frame.left) / frame.width) * (right - left), upper - within((event.clientY - frame.top) / frame.height) * (upper - lower)];
}

document.addEventListener("pointerdown", event => { if (event.target.id === "map" && view) start = position(event); });
document.addEventListener("pointermove", event => {
  if (!view || !element("map") || !(start || event.target.id === "map")) return;
  const here = position(event), value = height(here);
  element("cursor").textContent = `x ${micrometres(here[0])}, y ${micrometres(here[1])}: ${isNaN(value) ? "not measured" : micrometres(value)}`;
  if (start) draw(document.querySelector("[name=tool]:checked").value, here);
});
document.addEventListener("pointerup", event => {
  if (!start) return;
  const tool = document.querySelector("[name=tool]:checked").value, here = position(event), from = start, number = element("viewer").dataset.row;
  const corners = [0, 1].map(k => Math.min(from[k], here[k])).concat([0, 1].map(k => Math.max(from[k], here[k])));
  if (tool === "line") draw(tool, here);
  start = null;
  if (tool === "line" || corners[0] === corners[2] || corners[1] === corners[3]) return;
  if (tool === "zoom") return void show(view.map, corners.join());
  const field = element(`rows.${number}.${tool}`), text = `${corners.map(length => +(length * 1e6).toPrecision(5)).join(" ")} um`;
  field.value = tool === "mask" && field.value ? `${field.value}; ${text}` : text;
  field.dispatchEvent(new Event("input", { bubbles: true }));
});
document.addEventListener("click", event => { if (event.target.id === "whole" && view) show(view.map, ""); });
