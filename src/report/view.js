
// Views: a scan in three dimensions, before and after, coloured by its channels. What all views show stands
// in the page's address, as in #view=before&channel=height.

const ORIGINAL = 0xc8ccd2;
const COMPLETED = 0xe8862a;
const NOTHING = 0x9aa0a8;
// Viridis (CC0), from low to high.
const RAMP = [0x440154, 0x472d7b, 0x3b528b, 0x2c728e, 0x21918c, 0x28ae80, 0x5ec962, 0xaddc30, 0xfde725];

// Ambient and diffuse light add up to 1: more would blot out relief. Where colours say something there is more of
// the first, so that they can be read in the shade.
function lighting(key) {
  const ambient = key === "shape" || key === "completed" ? 0.35 : 0.55;
  // Normals count whatever the scan's unit is.
  const normals = { vertexnormalsepsilon: 0, facenormalsepsilon: 0 };
  return { ambient, diffuse: 1 - ambient, specular: 0.08, roughness: 0.6, fresnel: 0.05, ...normals };
}
// A light far away in a direction seen from the camera, with which it turns: right, up, towards the reader. Plotly
// takes it in the coordinates of the picture, where what is behind the camera comes out mirrored. Near lights do
// not work: it takes the distance to them in mixed units.
function light([right, up, near]) {
  // Cotangent of 22.5°, half of what plotly's camera sees; the picture's shape; where it cuts off.
  const [cot, shape, [nearest, farthest]] = [2.414, 1.4, [0.01, 1000]];
  const away = 20;
  const depth = (farthest + nearest + (2 * farthest * nearest) / (near * away)) / (farthest - nearest);
  return { x: (-cot * right) / (near * shape), y: (-cot * up) / near, z: depth };
}
const LIGHT = light([-0.45, 0.5, 0.74]);
const RAKING_LIGHT = light([-0.55, 0.6, 0.58]);

function bytes(text) {
  return Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
}
const floats = (text) => new Float32Array(bytes(text).buffer);
function concat(first, second) {
  const all = new Float32Array(first.length + second.length);
  all.set(first);
  all.set(second, first.length);
  return all;
}
const indices = (text) => new Uint32Array(bytes(text).buffer);
const css = (color) => "#" + color.toString(16).padStart(6, "0");

// The ramp's colour at a share from 0 to 1.
function rampColor(share) {
  const place = Math.min(Math.max(share, 0), 1) * (RAMP.length - 1);
  const step = Math.min(Math.floor(place), RAMP.length - 2);
  const mix = (shift) => {
    const [a, b] = [(RAMP[step] >> shift) & 255, (RAMP[step + 1] >> shift) & 255];
    return Math.round(a + (b - a) * (place - step)) << shift;
  };
  return mix(16) | mix(8) | mix(0);
}

// The trace's colours, as 0xRRGGBB: of faces where the completed part is marked, so that its edge is sharp, and
// else of vertices.
function colors(view, key, faces) {
  const channel = view.channels.find((channel) => channel.key === key);
  if (key === "completed") {
    const color = (_, face) => (face < view.original_faces ? ORIGINAL : COMPLETED);
    return { facecolor: Uint32Array.from({ length: faces }, color) };
  }
  if (channel && channel.scale) {
    const { values, low, high } = channel.scale;
    const color = (value) => (isNaN(value) ? NOTHING : rampColor((value - low) / (high - low)));
    return { vertexcolor: Uint32Array.from(floats(values), color) };
  }
  if (channel) {
    const rgb = bytes(channel.colors);
    const color = (_, v) => (rgb[3 * v] << 16) | (rgb[3 * v + 1] << 8) | rgb[3 * v + 2];
    return { vertexcolor: Uint32Array.from({ length: rgb.length / 3 }, color) };
  }
  return { vertexcolor: new Uint32Array(view.vertices).fill(ORIGINAL) };
}

class View {
  constructor(figure) {
    this.figure = figure;
    this.scene = figure.querySelector(".scene");
    this.data = data.views[figure.dataset.view];
    // Two corners without faces make the box around the scan a cube: plotly stretches what it draws to a cube of its
    // own before it takes the light's direction, and in stretched relief light would come from straight above.
    const { reach } = this.data;
    const boxed = (text) => concat(floats(text), [-reach, reach]);
    [this.x, this.y, this.z] = [this.data.x, this.data.y, this.data.z].map(boxed);
    this.corners = [this.data.i, this.data.j, this.data.k].map(indices);
    const { eye, up } = this.data;
    this.camera = { eye: vector(eye), up: vector(up), center: vector([0, 0, 0]) };
    for (const button of this.buttons()) {
      button.addEventListener("click", () => choose(button.dataset));
    }
    this.scene.tabIndex = 0;
    this.scene.addEventListener("keydown", (event) => this.turn(event));
  }

  buttons() {
    return this.figure.querySelectorAll("button");
  }

  has(channel) {
    return this.figure.querySelector(`[data-channel="${CSS.escape(channel)}"]`) !== null;
  }

  show({ state, channel }) {
    const shown = this.has(channel) ? channel : "shape";
    for (const button of this.buttons()) {
      const pressed = button.dataset.state ? button.dataset.state === state : button.dataset.channel === shown;
      button.setAttribute("aria-pressed", String(pressed));
    }
    this.draw(state, shown);
    this.explain(shown);
  }

  draw(state, channel) {
    const end = state === "before" ? this.data.original_faces : this.corners[0].length;
    const [i, j, k] = this.corners.map((corner) => corner.subarray(0, end));
    const trace = {
      type: "mesh3d",
      x: this.x,
      y: this.y,
      z: this.z,
      i,
      j,
      k,
      ...colors(this.data, channel, end),
      hoverinfo: "skip",
      lighting: lighting(channel),
      lightposition: this.data.is_flat ? RAKING_LIGHT : LIGHT,
    };
    const range = [-1.02 * this.data.reach, 1.02 * this.data.reach];
    const axis = { visible: false, autorange: false, range };
    const layout = {
      // Of equal ranges: by "data", plotly would bring flat scans too near.
      scene: { aspectmode: "cube", dragmode: "orbit", camera: this.camera, xaxis: axis, yaxis: axis, zaxis: axis },
      margin: { l: 0, r: 0, t: 0, b: 0 },
      paper_bgcolor: "rgba(0,0,0,0)",
      modebar: { bgcolor: "rgba(0,0,0,0)", color: themed("quiet"), activecolor: themed("accent") },
      uirevision: "the camera stays where it is",
    };
    const config = {
      displaylogo: false,
      responsive: true,
      modeBarButtons: [["toImage", "resetCameraDefault3d"]],
    };
    Plotly.react(this.scene, [trace], layout, config);
  }

  // What the colours mean.
  explain(key) {
    const legend = this.figure.querySelector(".legend");
    legend.replaceChildren();
    const channel = this.data.channels.find((channel) => channel.key === key);
    if (channel && channel.scale) {
      const ramp = append(legend, "div", "", "ramp");
      append(ramp, "span", channel.scale.ends[0]);
      const bar = append(ramp, "i", "");
      bar.style.background = `linear-gradient(to right, ${RAMP.map(css).join(", ")})`;
      append(ramp, "span", channel.scale.ends[1]);
    }
    if (key === "completed") {
      for (const [text, color] of [["scanned", ORIGINAL], ["completed", COMPLETED]]) {
        append(legend, "span", text, "swatch").style.setProperty("--swatch", css(color));
      }
    }
    const marks = { shape: "The shape alone, lit from the upper left.", completed: "" };
    append(legend, "p", channel ? channel.note : marks[key], "note");
  }

  // Arrow keys turn the view.
  turn(event) {
    const angle = Math.PI / 18;
    const turns = { ArrowLeft: [-angle, 0], ArrowRight: [angle, 0], ArrowUp: [0, angle], ArrowDown: [0, -angle] };
    if (!(event.key in turns)) return;
    event.preventDefault();
    const [around, over] = turns[event.key];
    const camera = this.scene.layout.scene.camera;
    const up = normal(camera.up);
    const side = normal(cross(up, camera.eye));
    const eye = rotated(rotated(camera.eye, up, around), side, -over);
    Plotly.relayout(this.scene, { "scene.camera": { ...camera, eye, up: rotated(up, side, -over) } });
  }

  // Browsers leave what WebGL drew out of what they print: a copy is printed.
  keepStill() {
    const scene = this.scene._fullLayout && this.scene._fullLayout.scene;
    const drawn = this.scene.querySelector("canvas");
    if (!drawn || !scene) return;
    scene._scene.glplot.redraw();
    const still = this.figure.querySelector(".still");
    [still.width, still.height] = [drawn.width, drawn.height];
    still.getContext("2d").drawImage(drawn, 0, 0);
  }
}

const vector = ([x, y, z]) => ({ x, y, z });
const dot = (a, b) => a.x * b.x + a.y * b.y + a.z * b.z;
const cross = (a, b) => vector([a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x]);
const sum = (a, s, b) => vector([a.x + s * b.x, a.y + s * b.y, a.z + s * b.z]);
const normal = (a) => sum(vector([0, 0, 0]), 1 / Math.sqrt(dot(a, a)), a);
// Rodrigues' formula.
function rotated(a, axis, angle) {
  const along = sum(vector([0, 0, 0]), Math.cos(angle), a);
  const beside = sum(along, Math.sin(angle), cross(axis, a));
  return sum(beside, (1 - Math.cos(angle)) * dot(axis, a), axis);
}

function append(parent, tag, text, name = "") {
  const element = parent.appendChild(document.createElement(tag));
  element.textContent = text;
  element.className = name;
  return element;
}

// What is shown: what the address says, and else all of the scan in its colours.
function wanted() {
  const address = new URLSearchParams(location.hash.slice(1));
  const colored = views.some((view) => view.has("color"));
  return {
    state: address.get("view") === "before" ? "before" : "after",
    channel: address.get("channel") || (colored ? "color" : "shape"),
  };
}

function showWanted() {
  const now = wanted();
  for (const view of views) view.show(now);
}

// A button was pressed: the address follows, and the views follow the address.
function choose({ state, channel }) {
  const now = wanted();
  const address = new URLSearchParams({ view: state || now.state, channel: channel || now.channel });
  history.replaceState(null, "", "#" + address);
  showWanted();
}

function canDraw() {
  const canvas = document.createElement("canvas");
  return canvas.getContext("webgl") !== null;
}

const views = [];
if (canDraw()) {
  for (const figure of document.querySelectorAll("[data-view]")) views.push(new View(figure));
  showWanted();
  addEventListener("hashchange", showWanted);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", showWanted);
  addEventListener("beforeprint", () => views.forEach((view) => view.keepStill()));
} else {
  for (const scene of document.querySelectorAll(".scene")) {
    append(scene, "p", "This browser cannot draw in three dimensions: WebGL is missing or switched off.");
  }
}
