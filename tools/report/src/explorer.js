// The views of the residual: one copy of the samples, drawn as the reader chooses.
function explore(data, config, narrow) {
  const GAP = 65535;
  const decoded = new Map();
  function column(number) {
    if (number === null || number === undefined) return null;
    if (decoded.has(number)) return decoded.get(number);
    const { from, step, count, codes } = data.columns[number];
    let values;
    if (codes === undefined) {
      values = Array.from({ length: count }, (_, i) => from + step * i);
    } else {
      const bytes = atob(codes);
      values = new Array(bytes.length / 2);
      for (let i = 0; i < values.length; i++) {
        const code = bytes.charCodeAt(2 * i) | (bytes.charCodeAt(2 * i + 1) << 8);
        values[i] = code === GAP ? null : from + step * code;
      }
    }
    decoded.set(number, values);
    return values;
  }

  const records = document.getElementById("choose-record");
  const channels = document.getElementById("choose-channel");
  const boxes = Array.from(document.querySelectorAll(".choose-stage"));
  const option = (list, text, value) => list.add(new Option(text, value));
  // Names are escaped for figures; a list shows them as they are.
  const plain = (text) => text.replace(/&lt;/g, "<").replace(/&gt;/g, ">").replace(/&amp;/g, "&");
  data.records.forEach((record, i) => option(records, plain(record.name), i));
  const names = [];
  data.records.forEach((record) => record.channels.forEach((channel) => {
    if (!names.includes(channel.name)) names.push(channel.name);
  }));
  names.forEach((name) => option(channels, plain(name), name));
  document.getElementById("channel-label").hidden = names.length < 2;

  const minus = (p, m) => p.map((value, i) => (value === null || m[i] === null ? null : value - m[i]));
  const predicted = (channel, stage) => {
    const residual = column(channel.residuals[stage]);
    if (!residual) return null;
    const measured = column(channel.measured);
    return residual.map((value, i) =>
      value === null || measured[i] === null ? null : measured[i] + value / channel.perValue);
  };
  const axis = (title, more) => Object.assign({
    title: { text: title, standoff: 8 }, automargin: true, hoverformat: ".5~g", gridcolor: "#e3e6ea",
    zerolinecolor: "#aab2bd", zerolinewidth: 1, showline: true, linecolor: "#5a6572", ticks: "outside",
    tickcolor: "#5a6572", ticklen: 4, nticks: narrow ? 6 : 8, exponentformat: "power" }, more);
  const layout = (x, y, more) => Object.assign({
    autosize: true, paper_bgcolor: "#ffffff", plot_bgcolor: "#ffffff", hovermode: "closest",
    font: { family: "system-ui, sans-serif", size: 13, color: "#1d2530" },
    margin: { l: 56, r: narrow ? 12 : 40, t: 12, b: 48 }, modebar: { orientation: "v", bgcolor: "#ffffff" },
    legend: { orientation: "h", x: 0, xanchor: "left", y: 1.02, yanchor: "bottom", itemsizing: "constant" },
    showlegend: true, xaxis: x, yaxis: y }, more);
  const line = (name, x, y, colour, width, more) => Object.assign({ type: "scatter", mode: "lines", name, x, y,
    line: { color: colour, width }, legendgroup: name }, more);
  const grey = "#8a94a0";
  const stageLine = (stage, x, y, width, more) => {
    const style = data.stages[stage];
    return line(style.name, x, y, style.colour, width,
      Object.assign({ line: { color: style.colour, width, dash: style.dash } }, more));
  };
  const nothing = (text) => [[], layout(axis(""), axis(""), { showlegend: false,
    xaxis: { visible: false }, yaxis: { visible: false },
    annotations: [{ text, showarrow: false, xref: "paper", yref: "paper", x: 0.5, y: 0.5 }] })];

  // Mean of y over bins of x, each with enough samples; where the motion is told apart, for x rising and falling.
  function binned(parts, apart) {
    let low = Infinity, high = -Infinity;
    parts.forEach(({ x }) => x.forEach((value) => {
      if (value !== null) { low = Math.min(low, value); high = Math.max(high, value); }
    }));
    const count = 24;
    const fresh = () => Array.from({ length: count }, () => []);
    const bins = apart ? [fresh(), fresh()] : [fresh()];
    parts.forEach(({ x, y }) => x.forEach((value, i) => {
      if (value === null || y[i] === null || !(high > low)) return;
      const before = x[Math.max(i - 1, 0)], after = x[Math.min(i + 1, x.length - 1)];
      const way = apart && after < before ? 1 : 0;
      bins[way][Math.min(count - 1, Math.floor(count * (value - low) / (high - low)))].push(y[i]);
    }));
    return bins.map((one) => {
      const curve = { x: [], mean: [], low: [], high: [] };
      one.forEach((values, bin) => {
        if (values.length < 4) return;
        values.sort((a, b) => a - b);
        const share = (part) => values[Math.round(part * (values.length - 1))];
        curve.x.push(low + (bin + 0.5) * (high - low) / count);
        curve.mean.push(values.reduce((sum, value) => sum + value, 0) / values.length);
        curve.low.push(share(1 / 6));
        curve.high.push(share(5 / 6));
      });
      return curve;
    });
  }
  const ways = (apart, way) => (apart ? (way === 0 ? "mean, forwards" : "mean, backwards") : "mean");
  const WAYS = ["#D55E00", "#009E73"];

  const views = {
    time(channel, stages) {
      const time = column(channel.time);
      const traces = [line("measured", time, column(channel.measured), "#000000", 2)];
      stages.forEach((stage) => traces.push(stageLine(stage, time, predicted(channel, stage), 1.5)));
      stages.forEach((stage) => traces.push(line(data.stages[stage].name, time, column(channel.residuals[stage]),
        data.stages[stage].colour, 1, { yaxis: "y2", showlegend: false })));
      if (channel.noise) {
        const ends = [time[0], time[time.length - 1]];
        [1, -1].forEach((sign) => traces.push(line("noise", ends, [sign * channel.noise, sign * channel.noise],
          "#000000", 1, { yaxis: "y2", showlegend: false, line: { color: "#000000", width: 1, dash: "dot" } })));
      }
      return [traces, layout(axis(channel.timeLabel, { anchor: "y2" }), axis(channel.label, { domain: [0.4, 1] }),
        { yaxis2: axis(channel.residualLabel, { domain: [0, 0.32] }) })];
    },
    loop(channel, stages) {
      if (!channel.loop) return nothing("no loop: what drives this record is not in it");
      const part = (values) => values && values.slice(channel.loop.range[0], channel.loop.range[1] + 1);
      const other = part(column(channel.loop.other));
      const curve = (values) => (channel.loop.across ? [other, values] : [values, other]);
      const [x, y] = curve(part(column(channel.measured)));
      const traces = [line("measured", x, y, "#000000", 2)];
      stages.forEach((stage) => {
        const [x, y] = curve(part(predicted(channel, stage)));
        traces.push(stageLine(stage, x, y, 1.75));
      });
      const [across, up] = channel.loop.across ? [channel.loop.label, channel.label] : [channel.label, channel.loop.label];
      return [traces, layout(axis(across), axis(up))];
    },
    parity(channel, stages) {
      const measured = column(channel.measured);
      const finite = measured.filter((value) => value !== null);
      const ends = [finite.reduce((a, b) => Math.min(a, b)), finite.reduce((a, b) => Math.max(a, b))];
      const traces = stages.map((stage) => points(stage, measured, predicted(channel, stage)));
      traces.unshift(line("perfect", ends, ends, grey, 1.5));
      return [traces, layout(axis("measured " + channel.label), axis(channel.predictedLabel))];
    },
    cause(channel, stages, role) {
      const cause = channel.causes[role];
      if (!cause) return nothing("not in this record: " + role);
      const x = column(cause.x);
      const traces = stages.map((stage) => points(stage, x, column(channel.residuals[stage])));
      if (stages.length) {
        const apart = role === "displacement";
        const last = stages[stages.length - 1];
        binned([{ x, y: column(channel.residuals[last]) }], apart).forEach((curve, way) =>
          traces.push(line(ways(apart, way), curve.x, curve.mean, WAYS[way], 2.5)));
      }
      return [traces, layout(axis(cause.label), axis(channel.residualLabel))];
    },
    slow(channel, stages) {
      if (!channel.slow) return nothing("the record is too short");
      const traces = stages.map((stage) => stageLine(stage, channel.slow.time, channel.slow.rms[stage], 1.75,
        { mode: "lines+markers", marker: { size: 5, color: data.stages[stage].colour } }));
      if (channel.noiseShare) {
        const time = channel.slow.time;
        traces.push(line("noise", [time[0], time[time.length - 1]], [channel.noiseShare, channel.noiseShare],
          "#000000", 1.25, { line: { color: "#000000", width: 1.25, dash: "dot" } }));
      }
      return [traces, layout(axis(channel.timeLabel), axis("normalised residual", { rangemode: "tozero" }))];
    },
    spectrum(channel, stages) {
      const found = channel.spectrum;
      if (!found) return nothing("the samples are not evenly spaced");
      const decades = (number) => column(number).map((value) => (value === null ? null : Math.pow(10, value)));
      const measured = decades(found.measured);
      const x = measured.map((_, i) => found.from + found.step * i);
      const traces = [line("measured", x, measured, grey, 1)];
      stages.forEach((stage) => {
        if (found.residuals[stage] === null) return;
        traces.push(line(data.stages[stage].name, x, decades(found.residuals[stage]), data.stages[stage].colour, 1.5));
      });
      return [traces, layout(axis(channel.frequencyLabel), axis(channel.spectrumLabel, { type: "log", dtick: 1 }))];
    },
    harmonics(channel, stages) {
      const found = channel.harmonics;
      if (!found) return nothing("this record does not repeat");
      const traces = [];
      stages.forEach((stage) => {
        if (!found.residuals[stage]) return;
        const x = found.residuals[stage].map((_, i) => i);
        traces.push({ type: "bar", name: data.stages[stage].name, x, y: found.residuals[stage],
          marker: { color: data.stages[stage].colour } });
      });
      const fundamental = Number(found.fundamental.toPrecision(4));
      return [traces, layout(axis("harmonic of " + fundamental + " Hz (0: mean)", { dtick: 1, showgrid: false }),
        axis("normalised residual", { rangemode: "tozero" }), { bargap: 0.25 })];
    },
  };
  function points(stage, x, y) {
    const { name, colour } = data.stages[stage];
    return { type: "scatter", mode: "markers", name, x, y,
      marker: { color: colour, size: 3, opacity: 0.45 } };
  }

  const elements = Array.from(document.querySelectorAll(".view"));
  function show() {
    const record = data.records[Number(records.value)];
    const channel = record.channels.find((one) => one.name === channels.value) || record.channels[0];
    const wanted = boxes.filter((box) => box.checked).map((box) => Number(box.value));
    const stages = wanted.filter((stage) => channel.residuals[stage] !== null);
    const missing = wanted.filter((stage) => !stages.includes(stage)).map((stage) => plain(data.stages[stage].name));
    const sampled = channel.drawn < channel.samples
      ? ", " + channel.drawn + " of " + channel.samples + " samples are drawn" : "";
    document.getElementById("chosen").textContent = record.title + ": " + plain(channel.name) + sampled +
      (missing.length ? "; no prediction by " + missing.join(", ") : "");
    elements.forEach((element) => {
      const [kind, role] = element.dataset.view.split(":");
      const [traces, form] = views[kind](channel, stages, role);
      element.dataset.drawn = "yes";
      Object.assign(form, { paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", modebar: { bgcolor: "rgba(0,0,0,0)" } });
      withUnits(traces, form);
      Plotly.react(element, traces, form, config);
    });
  }
  [records, channels, ...boxes].forEach((choice) => choice.addEventListener("change", show));
  show();
}
