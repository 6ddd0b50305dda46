// Last of all scripts of the page: presses its buttons as a reader would, and notes what the view shows.
const pause = (milliseconds) => new Promise((resolve) => setTimeout(resolve, milliseconds));

// How many colours the view has, how much of it is not background, and a hash of all its pixels.
function seen() {
  const scene = document.querySelector(".scene");
  scene._fullLayout.scene._scene.glplot.redraw();
  const drawn = scene.querySelector("canvas");
  const copy = document.createElement("canvas");
  [copy.width, copy.height] = [drawn.width, drawn.height];
  const context = copy.getContext("2d");
  context.drawImage(drawn, 0, 0);
  const pixels = new Uint32Array(context.getImageData(0, 0, copy.width, copy.height).data.buffer);
  let [hash, covered] = [2166136261, 0];
  for (const pixel of pixels) {
    hash = Math.imul(hash ^ pixel, 16777619) >>> 0;
    covered += pixel >>> 24 > 0;
  }
  return { hash, colors: new Set(pixels).size, covered: covered / pixels.length };
}

async function drawn() {
  for (let tries = 0; tries < 100; tries += 1) {
    const scene = document.querySelector(".scene");
    if (scene && scene._fullLayout && scene._fullLayout.scene._scene) break;
    await pause(100);
  }
  await pause(300);
}

async function probe() {
  await drawn();
  const result = { at_start: seen(), steps: [] };
  const press = async (button) => {
    button.click();
    await pause(300);
    const { state, channel } = button.dataset;
    const { height, width } = button.getBoundingClientRect();
    const legend = document.querySelector(".legend").textContent;
    result.steps.push({ button: state || channel, pressed: button.ariaPressed, hash: location.hash, height, width, legend, seen: seen() });
  };
  for (const name of ["channel", "state"]) {
    for (const button of document.querySelectorAll(`button[data-${name}]`)) await press(button);
  }
  location.hash = "#view=before&channel=shape";
  await pause(300);
  result.by_address = seen();
  const scene = document.querySelector(".scene");
  scene.dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowLeft" }));
  await pause(300);
  result.turned = seen();
  const plots = [...document.querySelectorAll("[data-plot]")];
  result.plots = plots.map((plot) => plot.querySelectorAll("path").length);
  dispatchEvent(new Event("beforeprint"));
  const still = document.querySelector(".still");
  const copied = still.getContext("2d").getImageData(0, 0, still.width, still.height).data;
  result.still_covered = copied.filter((value, index) => index % 4 === 3 && value > 0).length / (copied.length / 4);
  dispatchEvent(new Event("afterprint"));
  result.overflow = document.documentElement.scrollWidth - innerWidth;
  return result;
}

probe()
  .catch((error) => ({ failed: String(error && error.stack) }))
  .then((result) => {
    const element = document.createElement("pre");
    element.id = "result";
    element.textContent = JSON.stringify({ ...result, wrong });
    document.body.append(element);
  });
