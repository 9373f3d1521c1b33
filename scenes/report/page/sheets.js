"use strict";
// Target and film in 3-D: linked cameras, a slider of temperature, colours.
// Shades are calculated here and shown as colours: the library's own light fails in a parallel projection.

const TURN_DEG = 10, ZOOM = 1.1, HEATING_MS = 4000;
const VIEWS = { front: [0, 0, 1], side: [1, 0, 0.18], foot: [0, -1, 0.3] };

class Sheets {
  constructor(data) {
    this.data = data;
    this.panels = ["target-3d", "film-3d"].map((id) => document.getElementById(id)).filter(Boolean);
    this.film = document.getElementById("film-3d");
    this.triangles = new Map(this.panels.map((panel) => [panel, unpackIndices(this.surface(panel).triangles)]));
    this.states = unpackNumbers(data.film.vertices_mm);
    this.size = this.states.length / data.temperature_c.length;
    this.error = data.film.error && unpackNumbers(data.film.error);
    // The slider runs along the ramp, degree by degree, so that cooling has its own part of it.
    this.way = [0];
    data.temperature_c.slice(1).forEach((hot, i) => {
      this.way.push(this.way[i] + Math.abs(hot - data.temperature_c[i]));
    });
    this.points = new Map();
    this.colours = "plain";
    this.linking = false;
    this.zoom = 1;
  }

  surface(panel) {
    return panel === this.film ? this.data.film : this.data.target;
  }

  // The two calculated states around a place on the ramp, and how far it is from the first to the second.
  around(place) {
    const last = this.way.length - 1;
    let next = this.way.findIndex((reached) => reached >= place - 1e-9);
    if (next < 0) next = last;
    const before = Math.max(next - 1, 0);
    const length = this.way[next] - this.way[before];
    return { before, next, share: length > 0 ? Math.min(1, (place - this.way[before]) / length) : 1 };
  }

  filmAt(place) {
    const { before, next, share } = this.around(place);
    const found = new Float64Array(this.size);
    for (let i = 0; i < this.size; i++) {
      found[i] = (1 - share) * this.states[before * this.size + i] + share * this.states[next * this.size + i];
    }
    return found;
  }

  tellPlace(place) {
    const { before, next, share } = this.around(place);
    const hot = this.data.temperature_c;
    const degrees = (1 - share) * hot[before] + share * hot[next];
    const way = hot[next] < hot[before] ? ", cooling" : "";
    const calculated = share > 1 - 1e-6 || share < 1e-6;
    const how = calculated ? "calculated" : `between ${hot[before].toFixed(0)} and ${hot[next].toFixed(0)} °C`;
    return { degrees: `${degrees.toFixed(0)} °C${way}`, how };
  }

  hottest() {
    return `${this.data.temperature_c[this.data.hottest].toFixed(0)} °C`;
  }

  async draw() {
    const { low_mm: low, high_mm: high } = this.data;
    const lengths = low.map((value, axis) => high[axis] - value);
    this.ratio = lengths.map((length) => (1.9 * length) / Math.max(...lengths));
    const axis = (k) => ({ visible: false, range: [low[k], high[k]], autorange: false });
    const scene = {
      xaxis: axis(0), yaxis: axis(1), zaxis: axis(2),
      aspectmode: "manual", aspectratio: this.aspect(),
      camera: this.camera(this.data.view_from), dragmode: "orbit",
    };
    const layout = { scene, margin: { l: 0, r: 0, t: 0, b: 0 }, paper_bgcolor: "rgba(0,0,0,0)", showlegend: false };
    const config = {
      displaylogo: false, responsive: true, modeBarButtons: [["toImage"]], toImageButtonOptions: { scale: 2 },
    };
    for (const panel of this.panels) {
      const triangles = this.triangles.get(panel);
      const points = panel === this.film
        ? this.filmAt(this.way[this.data.hottest]) : unpackNumbers(this.surface(panel).vertices_mm);
      this.points.set(panel, points);
      const trace = {
        type: "mesh3d",
        x: everyThird(points, 0), y: everyThird(points, 1), z: everyThird(points, 2),
        i: everyThird(triangles, 0), j: everyThird(triangles, 1), k: everyThird(triangles, 2),
        vertexcolor: this.painted(panel),
        lighting: { ambient: 1, diffuse: 0, specular: 0, fresnel: 0 },
        hovertemplate: "x %{x:.1f} mm<br>y %{y:.1f} mm<br>z %{z:.2f} mm<extra></extra>",
      };
      await Plotly.newPlot(panel, [trace], structuredClone(layout), config);
      panel.on("plotly_relayouting", (change) => this.link(panel, change));
      panel.on("plotly_relayout", (change) => this.link(panel, change));
      panel.addEventListener("keydown", (event) => this.key(event));
    }
  }

  aspect() {
    const [x, y, z] = this.ratio.map((length) => length * this.zoom);
    return { x, y, z };
  }

  camera(from) {
    const length = Math.hypot(...from) / 2;
    const [x, y, z] = from.map((value) => value / length);
    const up = Math.abs(y) > 0.9 * 2 ? { x: 0, y: 0, z: 1 } : { x: 0, y: 1, z: 0 };
    return { eye: { x, y, z }, up, center: { x: 0, y: 0, z: 0 }, projection: { type: "orthographic" } };
  }

  // What one panel was turned or zoomed to, the other follows.
  link(source, change) {
    const moved = {};
    for (const key of ["scene.camera", "scene.aspectratio"]) if (change[key]) moved[key] = change[key];
    if (this.linking || !Object.keys(moved).length) return;
    if (moved["scene.aspectratio"]) this.zoom = moved["scene.aspectratio"].x / this.ratio[0];
    this.move(moved, this.panels.filter((panel) => panel !== source));
  }

  async move(change, panels = this.panels) {
    this.linking = true;
    await Promise.all(panels.map((panel) => Plotly.relayout(panel, structuredClone(change))));
    this.linking = false;
  }

  look(name) {
    this.move({ "scene.camera": this.camera(VIEWS[name] || this.data.view_from) });
  }

  key(event) {
    const turns = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
    if (event.key in turns) this.turn(...turns[event.key]);
    else if (event.key === "+" || event.key === "=") this.zoomBy(ZOOM);
    else if (event.key === "-") this.zoomBy(1 / ZOOM);
    else return;
    event.preventDefault();
  }

  turn(right, above) {
    const camera = structuredClone(this.film.layout.scene.camera);
    const eye = [camera.eye.x, camera.eye.y, camera.eye.z], up = [camera.up.x, camera.up.y, camera.up.z];
    const turned = right ? rotated(eye, up, right) : rotated(eye, cross(eye, up), above);
    if (!right && Math.abs(dot(turned, up)) > 0.98 * Math.hypot(...turned)) return;
    [camera.eye.x, camera.eye.y, camera.eye.z] = turned;
    this.move({ "scene.camera": camera });
  }

  zoomBy(factor) {
    this.zoom *= factor;
    this.move({ "scene.aspectratio": this.aspect() });
  }

  async show(place) {
    this.place = place;
    const points = this.filmAt(place);
    this.points.set(this.film, points);
    await Plotly.restyle(this.film, {
      x: [everyThird(points, 0)], y: [everyThird(points, 1)], z: [everyThird(points, 2)],
      vertexcolor: [this.painted(this.film)],
    });
  }

  async colour(name) {
    this.colours = name;
    for (const panel of this.panels) await Plotly.restyle(panel, { vertexcolor: [this.painted(panel)] });
  }

  // The colour of each vertex: skin or a number's colour, shaded.
  painted(panel) {
    const points = this.points.get(panel), shades = shaded(points, this.triangles.get(panel), this.data.light_from);
    const skin = channels(this.data.skin), scale = this.data.scales[this.colours];
    const table = scale && scale.colours.map(channels);
    const found = new Array(shades.length);
    for (let i = 0; i < shades.length; i++) {
      let value = null;
      if (this.colours === "height") value = points[3 * i + 2];
      else if (this.colours === "error" && panel === this.film) value = this.error[i];
      const base = value === null ? skin : looked(table, (value - scale.low) / (scale.high - scale.low));
      // Under shades as deep as the skin's a colour could not be read off its scale.
      const shade = value === null ? shades[i] : 0.45 + 0.55 * shades[i];
      found[i] = [...base.map((channel) => Math.min(1, channel * shade)), 1];
    }
    return found;
  }
}

function channels(colour) {
  return [1, 3, 5].map((start) => parseInt(colour.slice(start, start + 2), 16) / 255);
}

function looked(table, place) {
  const at = Math.min(Math.max(place, 0), 1) * (table.length - 1), before = Math.min(Math.floor(at), table.length - 2);
  return table[before].map((channel, k) => channel + (at - before) * (table[before + 1][k] - channel));
}

// How brightly each vertex is lit, by the normals of the triangles around it.
function shaded(points, triangles, light) {
  const normals = new Float64Array(points.length);
  for (let t = 0; t < triangles.length; t += 3) {
    const [a, b, c] = [3 * triangles[t], 3 * triangles[t + 1], 3 * triangles[t + 2]];
    const ux = points[b] - points[a], uy = points[b + 1] - points[a + 1], uz = points[b + 2] - points[a + 2];
    const vx = points[c] - points[a], vy = points[c + 1] - points[a + 1], vz = points[c + 2] - points[a + 2];
    const nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
    for (const corner of [a, b, c]) {
      normals[corner] += nx;
      normals[corner + 1] += ny;
      normals[corner + 2] += nz;
    }
  }
  const found = new Float64Array(points.length / 3), bright = Math.hypot(...light);
  for (let i = 0; i < found.length; i++) {
    const [x, y, z] = normals.subarray(3 * i, 3 * i + 3), length = Math.hypot(x, y, z) || 1;
    const lit = (x * light[0] + y * light[1] + z * light[2]) / (length * bright);
    found[i] = 0.22 + 0.78 * Math.max(0, lit) + (0.16 * z) / length;
  }
  return found;
}

function dot(a, b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

function cross(a, b) {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

// Rodrigues' rotation of a vector around an axis by some steps.
function rotated(vector, axis, steps) {
  const length = Math.hypot(...axis), unit = axis.map((value) => value / length);
  const angle = (steps * TURN_DEG * Math.PI) / 180, across = cross(unit, vector), along = dot(unit, vector);
  return vector.map((value, k) =>
    value * Math.cos(angle) + across[k] * Math.sin(angle) + unit[k] * along * (1 - Math.cos(angle)));
}

function showScale(scale) {
  document.getElementById("scale").classList.toggle("empty", !scale);
  if (!scale) return;
  document.getElementById("scale-bar").style.background = gradient(scale.colours);
  document.getElementById("scale-low").textContent = scale.low.toFixed(1);
  document.getElementById("scale-high").textContent = scale.high.toFixed(1);
  document.getElementById("scale-label").textContent = scale.label.replace("\n", "; ");
}

function connectSheets(sheets) {
  const slider = document.getElementById("temperature"), told = document.getElementById("temperature-told");
  const button = document.getElementById("heat"), caption = document.getElementById("film-caption");
  let wanted = null, heating = null;
  slider.max = String(sheets.way.at(-1));
  slider.value = String(sheets.way[sheets.data.hottest]);
  document.getElementById("temperature-marks").replaceChildren(
    ...sheets.way.map((place) => Object.assign(document.createElement("option"), { value: String(place) })));
  const tell = () => {
    const { degrees, how } = sheets.tellPlace(Number(slider.value));
    told.textContent = `${degrees}, ${how}`;
    slider.setAttribute("aria-valuetext", told.textContent);
    const colours = sheets.colours === "error" ? `, colours of the error at ${sheets.hottest()}` : "";
    caption.textContent = `Film at ${degrees}${colours}`;
  };
  // A slider speaks faster than surfaces are drawn: only its last word is shown.
  const update = async () => {
    tell();
    const busy = wanted !== null;
    wanted = Number(slider.value);
    if (busy) return;
    while (sheets.place !== wanted) await sheets.show(wanted);
    wanted = null;
  };
  const stop = () => {
    heating = null;
    button.textContent = "Heat";
  };
  const step = (now) => {
    if (!heating) return;
    const share = Math.min(1, (now - heating) / HEATING_MS);
    slider.value = String(share * Number(slider.max));
    update();
    if (share < 1) requestAnimationFrame(step);
    else stop();
  };
  slider.addEventListener("input", () => { stop(); update(); });
  button.addEventListener("click", () => {
    if (heating) return stop();
    heating = performance.now();
    button.textContent = "Stop";
    requestAnimationFrame(step);
  });
  document.getElementById("colours").addEventListener("change", (event) => {
    showScale(sheets.data.scales[event.target.value]);
    sheets.colour(event.target.value);
    tell();
  });
  document.getElementById("views").addEventListener("click", (event) => {
    if (event.target.dataset.view) sheets.look(event.target.dataset.view);
  });
  tell();
}

async function startSheets() {
  const message = document.getElementById("sheets-message");
  if (!webglWorks()) {
    message.textContent = "This browser has no WebGL: pictures of the shapes stand here instead of the 3-D view.";
    return;
  }
  try {
    await loadLibrary();
  } catch {
    message.textContent = "This browser is too old for the 3-D view: pictures of the shapes stand here instead.";
    return;
  }
  document.documentElement.classList.add("with-3d");
  const sheets = new Sheets(readData("sheets-data"));
  await sheets.draw();
  connectSheets(sheets);
  document.getElementById("sheets").dataset.ready = "yes";
}

startSheets();
