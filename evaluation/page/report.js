// Draws the charts of report.html with uPlot. Each div.charts carries its data as JSON: time_s,
// states, and charts = [{title, caption, axis, series: [{label, values}]}].
"use strict";
(() => {
  const SERIES = ["#b79df0", "#5b2fc0", "#d55e00", "#009e73", "#0072b2"];
  const STATES = { searching: "#b8b8c2", acquiring: "#e6a700", tracking: "#2f9e5b", lost: "#c62828" };
  const STRIP_PX = 10;

  const heightFor = (width) => (width < 700 ? 260 : 320);

  // A band of the states along the bottom of the plot.
  function drawStates(u, states) {
    const { ctx, bbox } = u;
    const height = STRIP_PX * devicePixelRatio;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    const t = u.data[0];
    for (let i = 0; i < t.length; ) {
      let j = i;
      while (j < t.length && states[j] === states[i]) ++j;
      const left = u.valToPos(t[i], "x", true);
      const right = u.valToPos(j < t.length ? t[j] : t[t.length - 1], "x", true);
      ctx.fillStyle = STATES[states[i]] || "#000";
      ctx.fillRect(left, bbox.top + bbox.height - height, Math.max(1, right - left), height);
      i = j;
    }
    ctx.restore();
  }

  // From a little below zero, where the states are, to the largest value in view; a few values far
  // beyond the others are cut off, else they would flatten everything else.
  function yRange(u) {
    const [first, last] = u.series[0].idxs || [0, u.data[0].length - 1];
    const values = [];
    for (let s = 1; s < u.data.length; ++s)
      if (u.series[s].show)
        for (let i = first; i <= last; ++i) if (u.data[s][i] != null) values.push(u.data[s][i]);
    if (values.length === 0) return [-0.07, 1];
    values.sort((a, b) => a - b);
    const top = Math.min(values[values.length - 1], 2.5 * values[Math.floor(0.95 * (values.length - 1))]) || 1;
    return [-0.07 * top, 1.05 * top];
  }

  function zoom(u, factor) {
    const { min, max } = u.scales.x;
    const middle = (min + max) / 2, half = ((max - min) / 2) * factor;
    const all = u.data[0];
    const left = Math.max(all[0], middle - half), right = Math.min(all[all.length - 1], middle + half);
    u.setScale("x", { min: left, max: right });
  }

  function pan(u, share) {
    const { min, max } = u.scales.x, all = u.data[0];
    let step = (max - min) * share;
    step = Math.max(all[0] - min, Math.min(all[all.length - 1] - max, step));
    u.setScale("x", { min: min + step, max: max + step });
  }

  function options(chart, states, width, sync) {
    return {
      width,
      height: heightFor(width),
      cursor: { sync: { key: sync }, drag: { x: true, y: false } },
      scales: { x: { time: false }, y: { range: (u) => yRange(u) } },
      axes: [{ label: "time (s)", size: 40, labelSize: 20 }, { label: chart.axis, size: 56, labelSize: 20 }],
      series: [
        { label: "time", value: (u, v) => (v == null ? "–" : v.toFixed(2) + " s") },
        ...chart.series.map((s, i) => ({
          label: s.label,
          stroke: SERIES[i % SERIES.length],
          width: 1.6,
          value: (u, v) => (v == null ? "–" : v.toFixed(2)),
        })),
      ],
      hooks: { draw: [(u) => drawStates(u, states)] },
    };
  }

  function element(parent, tag, text, className) {
    const e = document.createElement(tag);
    if (text) e.textContent = text;
    if (className) e.className = className;
    parent.append(e);
    return e;
  }

  function addChart(place, data, chart, sync) {
    const figure = element(place, "figure", "", "chart");
    const caption = element(figure, "figcaption");
    element(caption, "b", chart.title + " ");
    caption.append(chart.caption);
    const holder = element(figure, "div");
    const plot = new uPlot(options(chart, data.states, figure.clientWidth, sync),
      [data.time_s, ...chart.series.map((s) => s.values)], holder);
    const buttons = element(figure, "div");
    for (const [text, act] of [["−", () => zoom(plot, 2)], ["+", () => zoom(plot, 0.5)],
      ["◀", () => pan(plot, -0.5)], ["▶", () => pan(plot, 0.5)]])
      element(buttons, "button", text).onclick = act;
    return { plot, figure };
  }

  function addKey(place) {
    const key = element(place, "p", "Drag in a plot, or use its buttons, to zoom; double-click to see " +
      "all. A few values far beyond the others are cut off. The band under each plot is the tracker's " +
      "state: ", "states");
    for (const [state, color] of Object.entries(STATES)) {
      const entry = element(key, "span");
      element(entry, "i").style.background = color;
      entry.append(state);
    }
  }

  // A chart needs a width, so those of a closed section are drawn when it is opened.
  document.querySelectorAll(".charts").forEach((place, index) => {
    const data = JSON.parse(place.querySelector("script").textContent);
    let plots = null;
    new ResizeObserver(() => {
      if (place.clientWidth === 0) return;
      if (!plots) {
        addKey(place);
        plots = data.charts.map((chart) => addChart(place, data, chart, "sequence" + index));
      }
      for (const { plot, figure } of plots)
        if (plot.width !== figure.clientWidth)
          plot.setSize({ width: figure.clientWidth, height: heightFor(figure.clientWidth) });
    }).observe(place);
  });
})();
