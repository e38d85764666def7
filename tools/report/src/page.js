"use strict";
// The script library lies in the page packed, a third of its size; the licence before it stays readable.
async function unpack() {
  const packed = document.getElementById("library").textContent.split("*/")[1];
  const bytes = Uint8Array.from(atob(packed.trim()), (letter) => letter.charCodeAt(0));
  const plain = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  const library = document.createElement("script");
  library.textContent = await new Response(plain).text();
  document.head.append(library);
}

// What is shown beside the pointer: the name of each axis, the value, and the unit, which stands in the axis' title.
function withUnits(traces, layout) {
  const said = (trace, axis) => {
    const of = layout[(trace[axis + "axis"] || axis).replace(axis, axis + "axis")] || {};
    const title = (of.title && of.title.text) || "";
    const [, name, unit] = /^(.*) \(([^()]*)\)$/.exec(title) || ["", title, ""];
    // A name may hold what the library would take for a value.
    const plain = name.replace(/%/g, "&#37;");
    const places = trace.type === "bar" && axis === "x" ? "" : ":.5~g";
    return (plain ? plain + ": " : "") + "%{" + axis + places + "}" + (unit ? "\u00a0" + unit : "");
  };
  for (const trace of traces) {
    if (trace.hoverinfo || trace.hovertemplate) continue;
    trace.hovertemplate = said(trace, "x") + "<br>" + said(trace, "y") + "<extra>" + (trace.name || "").replace(/%/g, "&#37;") + "</extra>";
  }
}

function show() {
  const stored = JSON.parse(document.getElementById("figures").textContent);
  // On a small screen the buttons would cover the figure, and fingers zoom without them.
  const narrow = window.innerWidth < 600;
  // The library's own buttons that would send a figure somewhere are off: a page fetches and sends nothing.
  const config = { responsive: true, displaylogo: false, displayModeBar: narrow ? false : "hover", showSendToCloud: false,
    modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d", "zoomIn2d", "zoomOut2d"] };

  function draw(element) {
    if (element.dataset.drawn) return;
    element.dataset.drawn = "yes";
    const figure = stored.figures[Number(element.dataset.figure)];
    // A number in place of an array is the number of a column.
    for (const trace of figure.data) {
      for (const axis of ["x", "y"]) {
        if (typeof trace[axis] === "number") trace[axis] = stored.columns[trace[axis]];
      }
    }
    // The page's own ground shows, light or dark.
    figure.layout.paper_bgcolor = figure.layout.plot_bgcolor = "rgba(0,0,0,0)";
    figure.layout.modebar = { bgcolor: "rgba(0,0,0,0)" };
    if (narrow) {
      figure.layout.margin.r = 12;
      // Two panels on top of each other leave little room beside them.
      for (const axis of [figure.layout.yaxis, figure.layout.yaxis2]) {
        if (axis && axis.title) axis.title.font = { size: 10 };
      }
    }
    withUnits(figure.data, figure.layout);
    Plotly.newPlot(element, figure.data, figure.layout, config);
    if (figure.layout.meta && figure.layout.meta.switchable) scaleSwitch(element);
  }

  // Beside the figure and not in it, where they would cover its axis on a small screen.
  function scaleSwitch(element) {
    const group = document.createElement("div");
    group.className = "switch";
    group.setAttribute("role", "group");
    group.setAttribute("aria-label", "Division of the ordinate");
    [["linear", "linear"], ["logarithmic", "log"]].forEach(([label, type], index) => {
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = label;
      button.setAttribute("aria-pressed", String(index === 0));
      button.addEventListener("click", () => {
        Plotly.relayout(element, { "yaxis.type": type, "yaxis.autorange": true });
        group.querySelectorAll("button").forEach((other) =>
          other.setAttribute("aria-pressed", String(other === button)));
      });
      group.append(button);
    });
    element.after(group);
  }

  // A figure inside a closed record has no size yet: it is drawn when the record is opened.
  const visible = (element) => !element.closest("details:not([open])");
  const plots = Array.from(document.querySelectorAll(".plot"));
  const fixed = plots.filter((element) => element.dataset.figure !== undefined);
  fixed.filter(visible).forEach(draw);
  if (stored.explorer) explore(stored.explorer, config, narrow);
  document.querySelectorAll("details").forEach((record) =>
    record.addEventListener("toggle", () => {
      if (record.open) fixed.filter((element) => record.contains(element)).forEach(draw);
    }));

  // On paper a figure is as wide as the sheet (A4 less its margins), whatever the window was.
  const drawn = () => plots.filter((element) => element.dataset.drawn && visible(element));
  window.addEventListener("beforeprint", () => drawn().forEach((element) =>
    Plotly.relayout(element, { width: element.closest(".half") ? 320 : 670 })));
  window.addEventListener("afterprint", () => drawn().forEach((element) =>
    Plotly.relayout(element, { width: null, autosize: true })));
}

unpack().then(show).catch((error) => {
  console.error(error);
  document.getElementById("undrawn").hidden = false;
});
