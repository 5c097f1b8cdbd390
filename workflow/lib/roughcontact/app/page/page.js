"use strict";
// A button sends all fields of the page; the answer is the page after that, which takes the place of this one.
const page = document.body.dataset.page;
const element = id => document.getElementById(id);
let typing = 0, queue = Promise.resolve();

// Makes an element what it is in the answer, but for what was typed into a field and for what was opened.
function merge(old, now) {
  if (old.isEqualNode(now)) return;
  if (old.nodeName !== now.nodeName || old.id !== now.id || old.nodeName === "#text") return old.replaceWith(now);
  for (const name of old.getAttributeNames()) if (name !== "open" && !now.hasAttribute(name)) old.removeAttribute(name);
  for (const { name, value } of now.attributes)
    if (name !== "open" && old.getAttribute(name) !== value) old.setAttribute(name, value);
  const children = [...now.childNodes];
  while (old.childNodes.length > children.length) old.lastChild.remove();
  children.forEach((child, index) => old.childNodes[index] ? merge(old.childNodes[index], child) : old.append(child));
}

async function put(response) {
  const answer = new DOMParser().parseFromString(await response.text(), "text/html");
  const next = answer.querySelector("[data-ask]"), focus = answer.querySelector("[autofocus]");
  for (const now of answer.querySelectorAll("main > *")) merge(element(now.id), now);
  if (focus) element(focus.id).focus();
  if (next) ask(next.dataset.ask);
}

async function send(action, more = []) {
  const body = new URLSearchParams([...document.forms].flatMap(form => [...new FormData(form)]).concat(more));
  await put(await fetch(`${action}?page=${page}`, { method: "POST", body }));
}

async function upload(files) {
  const paths = [], refused = [];
  for (const file of files) {
    const response = await fetch(`drop?page=${page}&name=${encodeURIComponent(file.name)}`, { method: "POST", body: file });
    if (response.ok) paths.push(["page.dropped", await response.text()]);
    else refused.push(response);
  }
  await send("add", paths);
  if (refused.length) await put(refused[0]);
}

function tell() {
  element("problem").textContent = "No answer: start roughcontact app again, and open the address that it prints";
}

function ask(action, detail) {
  document.body.ariaBusy = true;
  queue = queue.then(() => action === "drop" ? upload(detail) : send(action, detail)).catch(tell)
    .finally(() => { document.body.ariaBusy = false; });
}

document.addEventListener("submit", event => {
  event.preventDefault();
  const { name, value } = event.submitter;
  ask(event.submitter.getAttribute("formaction"), name ? [[name, value]] : []);
});
document.addEventListener("input", event => {
  clearTimeout(typing);
  if (event.target.type === "file") ask("drop", [...event.target.files]);
  else typing = setTimeout(ask, 200, "check");
});
for (const name of ["dragover", "drop"])  // a file beside the field would take the place of the page
  document.addEventListener(name, event => { if (event.target.id !== "choose") event.preventDefault(); });
window.addEventListener("pagehide", () => navigator.sendBeacon(`leave?page=${page}`));
ask("check");
setInterval(() => send("state").catch(tell), 1000);
