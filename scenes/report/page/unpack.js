"use strict";
// What the page carries as text, back into numbers and scripts.

function readData(id) {
  return JSON.parse(document.getElementById(id).textContent);
}

function bytesOf(text) {
  return Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
}

function unpackNumbers(packed) {
  const whole = new Uint16Array(bytesOf(packed.uint16).buffer);
  return Float64Array.from(whole, (steps) => packed.low + packed.step * steps);
}

function unpackIndices(packed) {
  return new Uint32Array(bytesOf(packed.uint32).buffer);
}

// Every third number, from one of them on: an axis of points, a corner of triangles.
function everyThird(values, first) {
  const found = new Array(Math.floor(values.length / 3));
  for (let i = 0; i < found.length; i++) found[i] = values[3 * i + first];
  return found;
}

function webglWorks() {
  const canvas = document.createElement("canvas");
  return Boolean(canvas.getContext("webgl2") || canvas.getContext("webgl"));
}

// The library runs as a script of the page: its hash stands in the page's policy.
async function loadLibrary() {
  const packed = new Blob([bytesOf(document.getElementById("library").textContent)]);
  const text = await new Response(packed.stream().pipeThrough(new DecompressionStream("gzip"))).text();
  const script = document.createElement("script");
  script.textContent = text;
  document.head.append(script);
}

function gradient(colours) {
  return `linear-gradient(to right, ${colours.join(", ")})`;
}
