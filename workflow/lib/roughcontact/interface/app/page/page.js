"use strict";
// A change or a button is sent; the answer is the page after it, which takes the place of this one.
const element = id => document.getElementById(id);
const changes = {};  // of fields, until they are answered for
let queue = Promise.resolve(), waiting = 0;

// Makes an element what it is in the answer, but for what is being typed, opened, or drawn, and returns what stands in its
// place. What has an id stays where it is, with its focus, when others appear before it or go.
function merged(old, now) {
  if (old?.nodeName !== now.nodeName || old.id !== now.id || old.nodeName === "#text") return now;
  if (old.isEqualNode(now) || old.id === "cursor") return old;
  for (const name of [...old.getAttributeNames(), ...now.getAttributeNames()])
    if (["open", "viewBox", "points"].includes(name)) continue;
    else if (!now.hasAttribute(name)) old.removeAttribute(name);
    else if (old.getAttribute(name) !== now.getAttribute(name)) old.setAttribute(name, now.getAttribute(name));
  const before = [...old.childNodes];
  const children = [...now.childNodes].map((child, place) => merged(before.find(({ id }) => id && id === child.id) ?? before[place], child));
  for (const node of before) if (!children.includes(node)) node.remove();
  children.forEach((child, place) => { if (old.childNodes[place] !== child) old.insertBefore(child, old.childNodes[place]); });
  if (old.matches("input, select, textarea") && old !== document.activeElement) [old.value, old.checked] = [now.value, now.checked];
  return old;
}

async function put(response) {
  const text = await response.text();
  if (!response.ok) element("problem").textContent = text;
  else if (text) merged(document.querySelector("main"), new DOMParser().parseFromString(text, "text/html").querySelector("main"));
}

// One after the other: what is done last is answered last.
function step(ask, isBusy = true) {
  waiting += 1;
  document.body.ariaBusy = isBusy;
  queue = queue.then(ask).catch(() => {
    element("problem").textContent = "No answer: start roughcontact app again, and open the address that it prints";
  }).finally(() => { waiting -= 1; document.body.ariaBusy = waiting > 0; });
}

async function post(action) {
  const sent = { ...changes, ...action };
  if (!Object.keys(sent).length) return;  // an answer before it has had all
  const response = await fetch("", { method: "POST", body: JSON.stringify(sent) });
  for (const name in sent) if (response.ok && changes[name] === sent[name]) delete changes[name];
  await put(response);
}

async function upload(files) {
  const responses = [];
  for (const file of files) responses.push(await fetch(`drop?name=${encodeURIComponent(file.name)}`, { method: "POST", body: file }));
  const paths = await Promise.all(responses.filter(response => response.ok).map(response => response.text()));
  if (paths.length) await post({ "page.do": "add", "page.path": paths.join("\n") });
  for (const response of responses) if (!response.ok) await put(response);
}

document.addEventListener("submit", event => {
  event.preventDefault();
  step(async () => {
    await post(Object.fromEntries(new FormData(event.target, event.submitter)));
    const shown = element(event.submitter?.name);  // a further field, or the map, for which it asks
    shown?.focus();
    shown?.scrollIntoView({ block: "nearest" });  // it may have the focus already
  });
});
document.addEventListener("input", ({ target }) => {
  if (target.type === "file") {
    const files = [...target.files];
    step(() => upload(files));
    target.value = "";  // those that were left out may be chosen again
  } else if (!target.form) {
    changes[target.name] = target.type === "checkbox" && !target.checked ? "" : target.value;
    step(post);
  }
});
for (const name of ["dragover", "drop"])  // a file beside the field would take the place of the page
  document.addEventListener(name, event => { if (event.target.id !== "choose") event.preventDefault(); });

// The map of a row: heights under the pointer or along a line; a rectangle zooms in, or is written into the cell crop or mask.
let start = null, question = new AbortController();

async function tellHeights(address, line) {
  question.abort();  // the last one alone is answered
  question = new AbortController();
  const response = await fetch(`${address}?line=${line}`, { signal: question.signal });
  element("cursor")[response.ok ? "innerHTML" : "textContent"] = await response.text();  // an error has the words of a file
}

function use(map, tool, { x, y, width, height }) {
  const isRectangle = width && height, field = element(`rows.${map.dataset.row}.${tool}`);
  if (tool === "zoom") map.setAttribute("viewBox", isRectangle ? [x, y, width, height].join(" ") : map.dataset.whole);
  if (!field || !isRectangle) return;
  const text = `${[x, -y - height, x + width, -y].map(side => +side.toPrecision(5)).join(" ")} um`;
  field.value = tool === "mask" && field.value ? `${field.value}; ${text}` : text;
  field.dispatchEvent(new Event("input", { bubbles: true }));
}

for (const kind of ["pointerdown", "pointermove", "pointerup"]) document.addEventListener(kind, event => {
  const map = element("map"), outline = element("outline"), tool = document.querySelector("[name=tool]:checked")?.value;
  // a line that was drawn stays until the next one begins
  const isAsked = kind === "pointerdown" || (kind === "pointermove" && tool !== "line");
  if (!start && !(isAsked && map?.contains(event.target))) return;
  // µm to the right and downwards, as its picture has them
  const { x, y, width, height } = map.viewBox.baseVal;
  const point = new DOMPoint(event.clientX, event.clientY).matrixTransform(map.getScreenCTM().inverse());
  const [x2, y2] = [Math.min(x + width, Math.max(x, point.x)), Math.min(y + height, Math.max(y, point.y))];
  if (kind === "pointerdown") start = [x2, y2];
  const [x1, y1] = start ?? [x2, y2], isLine = tool === "line";
  outline.setAttribute("points", isLine ? [x1, y1, x2, y2] : [x1, y1, x2, y1, x2, y2, x1, y2, x1, y1]);
  tellHeights(map.dataset.address, isLine ? [x1, -y1, x2, -y2] : [x2, -y2, x2, -y2]).catch(() => {});
  if (kind === "pointerup") start = null;
  if (kind !== "pointerup" || isLine) return;
  use(map, tool, outline.getBBox());
  outline.removeAttribute("points");
});

for (const name of ["beforeunload", "pagehide"])  // before the next page is asked for, and when this one ends otherwise
  window.addEventListener(name, () => { if (Object.keys(changes).length) navigator.sendBeacon("", JSON.stringify(changes)); });
const news = async () => put(await fetch(`?seen=${document.querySelector("main").dataset.news}`));
setInterval(() => waiting || step(news, false), 1000);
