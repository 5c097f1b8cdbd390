"use strict";
// A change or a button sends all fields of the page; the answer is the page after it, which takes the place of this one.
const page = document.body.dataset.page;
const element = id => document.getElementById(id);
const fields = () => new URLSearchParams([...document.forms].flatMap(form => [...new FormData(form)]));
let queue = Promise.resolve(), unsaved = 0, waits = false, steps = 0;

// Makes an element what it is in the answer, but for what was typed into a field, opened, or drawn.
function merge(old, now) {
  if (old.isEqualNode(now)) return;
  if (old.nodeName !== now.nodeName || old.id !== now.id || old.nodeName === "#text") return old.replaceWith(now);
  if (old.nodeName === "polyline") return;
  const names = [...old.getAttributeNames(), ...now.getAttributeNames()].filter(name => name !== "open");
  for (const name of names)
    if (!now.hasAttribute(name)) old.removeAttribute(name);
    else if (old.getAttribute(name) !== now.getAttribute(name)) old.setAttribute(name, now.getAttribute(name));
  const children = [...now.childNodes];
  while (old.childNodes.length > children.length) old.lastChild.remove();
  children.forEach((child, index) => old.childNodes[index] ? merge(old.childNodes[index], child) : old.append(child));
}

async function put(response) {
  const answer = new DOMParser().parseFromString(await response.text(), "text/html");
  const focus = answer.querySelector("[autofocus]");
  for (const now of answer.querySelectorAll("main > *")) merge(element(now.id), now);
  if (focus) element(focus.id).focus();
}

async function send(action, more = []) {
  const body = fields();
  for (const [name, value] of more) body.append(name, value);
  const sent = unsaved;
  await put(await fetch(`${action}?page=${page}`, { method: "POST", body }));
  unsaved -= sent;
}

async function upload(files) {
  const responses = [], paths = [];
  for (const file of files) responses.push(await fetch(`drop?page=${page}&name=${encodeURIComponent(file.name)}`, { method: "POST", body: file }));
  for (const response of responses) if (response.ok) paths.push(["page.dropped", await response.text()]);
  await send("add", paths);
  for (const response of responses) if (!response.ok) await put(response);
}

function tell() {
  element("problem").textContent = "No answer: start roughcontact app again, and open the address that it prints";
}

function ask(action, detail) {
  steps += 1;
  document.body.ariaBusy = action !== "state";
  queue = queue.then(() => { waits &&= action !== "write"; return action === "drop" ? upload(detail) : send(action, detail); })
    .catch(tell).finally(() => { steps -= 1; document.body.ariaBusy = steps > 0; });
}

document.addEventListener("submit", event => {
  event.preventDefault();
  const { name, value } = event.submitter ?? {};
  ask((event.submitter ?? event.target).getAttribute(event.submitter ? "formaction" : "action"), name ? [[name, value]] : []);
});
document.addEventListener("input", event => {
  if (event.target.type === "file") return ask("drop", [...event.target.files]);
  if (event.target.form?.id !== "study") return;
  unsaved += 1;
  if (!waits) ask("write");  // one at most waits for its turn: it sends what is there then
  waits = true;
});
for (const name of ["dragover", "drop"])  // a file beside the field would take the place of the page
  document.addEventListener(name, event => { if (event.target.id !== "choose") event.preventDefault(); });
for (const name of ["beforeunload", "pagehide"])  // before the next page is asked for, and when this one ends otherwise
  window.addEventListener(name, () => navigator.sendBeacon(`leave?page=${page}`, unsaved ? fields() : ""));
ask("check");
setInterval(() => { if (!steps) ask("state"); }, 1000);
