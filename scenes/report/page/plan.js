"use strict";
// The passes of a layer in their order: played, paused, scrubbed.

const MARGIN_PX = 24, DASH_PX = [5, 4];

class PlanView {
  constructor(data, canvas) {
    this.data = data;
    this.canvas = canvas;
    this.pen = canvas.getContext("2d");
    this.choose(0);
  }

  choose(layer) {
    this.layer = this.data.layers[layer];
    this.passes = this.data.passes[this.layer.passes];
    this.clock = this.layer.total_s;
  }

  fit() {
    const { width, height } = this.canvas.getBoundingClientRect(), sharp = window.devicePixelRatio || 1;
    this.canvas.width = Math.round(width * sharp);
    this.canvas.height = Math.round(height * sharp);
    const xs = this.data.film_mm.map((point) => point[0]), ys = this.data.film_mm.map((point) => point[1]);
    const [left, right, low, high] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
    const scale = Math.min((width - 2 * MARGIN_PX) / (right - left), (height - 2 * MARGIN_PX) / (high - low));
    const x0 = width / 2 - (scale * (left + right)) / 2, y0 = height / 2 + (scale * (low + high)) / 2;
    this.scale = scale;
    this.place = ([x, y]) => [x0 + scale * x, y0 - scale * y];
    this.size = [width, height];
    this.pen.setTransform(sharp, 0, 0, sharp, 0, 0);
  }

  // How far a pass has come at the clock: whole segments, and the share of the next.
  reached(number) {
    const run = this.clock - this.layer.start_s[number], at = this.passes[number].at_s;
    if (run <= 0) return { segments: 0, share: 0 };
    if (run >= at.at(-1)) return { segments: at.length - 1, share: 0 };
    const next = at.findIndex((time) => time > run);
    return { segments: next - 1, share: (run - at[next - 1]) / (at[next] - at[next - 1]) };
  }

  // The pass that is under way at the clock, or the last one before it.
  current() {
    let found = 0;
    for (let k = 0; k < this.passes.length; k++) if (this.layer.start_s[k] <= this.clock) found = k;
    return found;
  }

  post() {
    const number = this.current(), pass = this.passes[number];
    const { segments, share } = this.reached(number);
    const segment = Math.min(segments, pass.at_s.length - 2);
    const within = segments > segment ? 1 : share;
    return { number, pass, segment, within, at: between(pass.points_mm[segment], pass.points_mm[segment + 1], within) };
  }

  draw() {
    this.fit();
    this.pen.clearRect(0, 0, ...this.size);
    this.outline(this.data.film_mm, "#c2c8cf", 1);
    this.pen.lineCap = "butt";
    this.pen.lineWidth = 1.2;
    this.passes.forEach((pass) => this.line(pass, pass.points_mm.length - 1, 0, "#ccd2d9"));
    this.pen.lineWidth = 1.6;
    this.passes.forEach((pass, number) => {
      const { segments, share } = this.reached(number);
      if (segments || share) this.line(pass, segments, share, null);
    });
    this.outline(this.data.cut_mm, "#111", 1.6);
    if (this.passes.length) this.dot();
    this.ruler();
  }

  // A pass up to a place; colours change along it, dashes run on over them.
  line(pass, segments, share, colour) {
    let length = 0;
    const last = Math.min(segments + (share > 0 ? 1 : 0), pass.points_mm.length - 1);
    for (let k = 0; k < last; k++) {
      const start = this.place(pass.points_mm[k]);
      let end = this.place(pass.points_mm[k + 1]);
      if (k === segments) end = between(start, end, share);
      this.pen.setLineDash(pass.concave ? DASH_PX : []);
      this.pen.lineDashOffset = length;
      this.pen.strokeStyle = colour || this.data.colours[pass.colour[k]];
      this.pen.beginPath();
      this.pen.moveTo(...start);
      this.pen.lineTo(...end);
      this.pen.stroke();
      length += Math.hypot(end[0] - start[0], end[1] - start[1]);
    }
    this.pen.setLineDash([]);
  }

  outline(points, colour, width) {
    this.pen.setLineDash([]);
    this.pen.strokeStyle = colour;
    this.pen.lineWidth = width;
    this.pen.beginPath();
    points.forEach((point) => this.pen.lineTo(...this.place(point)));
    this.pen.closePath();
    this.pen.stroke();
  }

  dot() {
    if (this.clock >= this.layer.total_s) return;
    this.pen.beginPath();
    this.pen.arc(...this.place(this.post().at), Math.max(4, (this.data.line_width_mm * this.scale) / 2), 0, 2 * Math.PI);
    this.pen.fillStyle = "rgba(17, 17, 17, 0.75)";
    this.pen.fill();
  }

  ruler() {
    const [width, height] = this.size;
    this.pen.fillStyle = "#55606e";
    this.pen.fillRect(width - MARGIN_PX - 10 * this.scale, height - 14, 10 * this.scale, 2);
    this.pen.font = "12px system-ui, sans-serif";
    this.pen.textAlign = "right";
    this.pen.fillText("10 mm", width - MARGIN_PX - 10 * this.scale - 6, height - 9);
  }
}

function between(a, b, share) {
  return [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])];
}

function minutes(seconds) {
  return `${Math.floor(seconds / 60)}:${String(Math.floor(seconds % 60)).padStart(2, "0")}`;
}

function startPlan() {
  const data = readData("strokes-data"), find = (id) => document.getElementById(id);
  const clock = find("clock"), play = find("play"), pace = find("pace");
  document.documentElement.classList.add("with-plan");
  const view = new PlanView(data, find("plan-canvas"));
  let before = null;

  const tell = () => {
    const told = view.passes.length ? readout(view) : { pass: "none: this layer stays polydomain" };
    find("told-time").textContent = `${minutes(view.clock)} of ${minutes(view.layer.total_s)} min`;
    for (const key of ["pass", "load", "speed", "radius", "side"]) find(`told-${key}`).textContent = told[key] || "";
    clock.setAttribute("aria-valuetext", find("told-time").textContent);
  };
  const show = () => {
    clock.value = String(view.clock);
    view.draw();
    tell();
  };
  const stop = () => {
    before = null;
    play.textContent = "Play";
  };
  const step = (now) => {
    if (before === null) return;
    view.clock = Math.min(view.layer.total_s, view.clock + ((now - before) / 1000) * Number(pace.value));
    before = now;
    show();
    if (view.clock < view.layer.total_s) requestAnimationFrame(step);
    else stop();
  };
  play.addEventListener("click", () => {
    if (before !== null) return stop();
    if (view.clock >= view.layer.total_s) view.clock = 0;
    play.textContent = "Pause";
    before = performance.now();
    requestAnimationFrame(step);
  });
  clock.addEventListener("input", () => {
    stop();
    view.clock = Number(clock.value);
    show();
  });
  const choose = (layer) => {
    stop();
    view.choose(layer);
    clock.max = String(view.layer.total_s);
    clock.disabled = play.disabled = !view.passes.length;
    show();
  };
  find("layers").addEventListener("change", (event) => choose(Number(event.target.value)));
  find("radius-bar").style.background = gradient(data.colours);
  find("radius-low").textContent = data.radius_mm[0].toFixed(1);
  find("radius-high").textContent = data.radius_mm[1].toFixed(1);
  new ResizeObserver(() => view.draw()).observe(view.canvas);
  choose(0);
}

function readout(view) {
  const { number, pass, segment, within } = view.post();
  const load = pass.load_g.length > 1
    ? (1 - within) * pass.load_g[segment] + within * pass.load_g[segment + 1] : pass.load_g[0];
  return {
    pass: `${number + 1} of ${view.passes.length}`,
    load: `${load.toFixed(2)} g`,
    speed: `${pass.speed_mm_s[segment].toFixed(2)} mm/s`,
    radius: `${pass.radius_mm[segment].toFixed(1)} mm`,
    side: pass.concave ? "concave" : "convex",
  };
}

startPlan();
