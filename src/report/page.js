"use strict";
// Draws what the page's data holds. Plots here; views in three dimensions behind it.

const data = JSON.parse(document.getElementById("data").textContent);
const root = document.documentElement;

// A colour of the style sheet, as it is now: light, dark, or on paper.
const themed = (name) => getComputedStyle(root).getPropertyValue("--" + name).trim();

function axisLayout(axis) {
  return {
    title: { text: axis.label, standoff: 8 },
    type: axis.log ? "log" : "linear",
    automargin: true,
    exponentformat: "power",
    gridcolor: themed("line"),
    linecolor: themed("line"),
    zerolinecolor: themed("quiet"),
    fixedrange: true,
  };
}

function plotLayout(plot) {
  const font = getComputedStyle(document.body).fontFamily;
  return {
    xaxis: axisLayout(plot.x),
    yaxis: { ...axisLayout(plot.y), rangemode: plot.y.log ? "normal" : "tozero" },
    barmode: "overlay",
    bargap: 0,
    margin: { l: 10, r: 10, t: 10, b: 10 },
    legend: { orientation: "h", y: 1.02, yanchor: "bottom", x: 0 },
    showlegend: plot.series.length > 1,
    font: { color: themed("text"), family: font, size: 13 },
    hoverlabel: { font: { family: font } },
    paper_bgcolor: "rgba(0,0,0,0)",
    plot_bgcolor: "rgba(0,0,0,0)",
  };
}

function plotTraces(plot) {
  return plot.series.map((series) => {
    const color = themed(series.part);
    const trace = { name: series.name, x: series.x, y: series.y };
    if (series.marks === "bars") {
      return { ...trace, type: "bar", opacity: 0.55, marker: { color } };
    }
    const dash = series.marks === "dashes" ? "dash" : "solid";
    const mode = series.marks === "points" ? "lines+markers" : "lines";
    return { ...trace, type: "scatter", mode, line: { color, dash, width: 2 }, marker: { color } };
  });
}

function drawPlots() {
  for (const element of document.querySelectorAll("[data-plot]")) {
    const plot = data.plots[element.dataset.plot];
    const config = { displayModeBar: false, responsive: true };
    Plotly.react(element, plotTraces(plot), plotLayout(plot), config);
  }
}

drawPlots();
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", drawPlots);
addEventListener("beforeprint", () => {
  root.classList.add("paper");
  drawPlots();
});
addEventListener("afterprint", () => {
  root.classList.remove("paper");
  drawPlots();
});
