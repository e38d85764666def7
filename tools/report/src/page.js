"use strict";
(function () {
  const stored = JSON.parse(document.getElementById("figures").textContent);
  // On a small screen the buttons would cover the figure, and fingers zoom without them.
  const narrow = window.innerWidth < 600;
  const config = { responsive: true, displaylogo: false, displayModeBar: narrow ? false : "hover",
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
    if (narrow) figure.layout.margin.r = 12;
    Plotly.newPlot(element, figure.data, figure.layout, config);
  }

  // A figure inside a closed record has no size yet: it is drawn when the record is opened.
  const visible = (element) => !element.closest("details:not([open])");
  const plots = Array.from(document.querySelectorAll(".plot"));
  plots.filter(visible).forEach(draw);
  document.querySelectorAll("details").forEach((record) =>
    record.addEventListener("toggle", () => {
      if (record.open) record.querySelectorAll(".plot").forEach(draw);
    }));

  // On paper a figure is as wide as the sheet (A4 less its margins), whatever the window was.
  const drawn = () => plots.filter((element) => element.dataset.drawn && visible(element));
  window.addEventListener("beforeprint", () => drawn().forEach((element) =>
    Plotly.relayout(element, { width: element.closest(".half") ? 320 : 670 })));
  window.addEventListener("afterprint", () => drawn().forEach((element) =>
    Plotly.relayout(element, { width: null, autosize: true })));
})();
