// The measured spectrum under partials and model: zoom by dragging, wheel or buttons, and a read-out under the pointer (uPlot).
"use strict";
klang.all('[data-figure="spectrum"]').forEach(function (figure) {
  var data = JSON.parse(figure.querySelector("script[data-spectrum]").textContent);
  var partials = JSON.parse(figure.querySelector("script[data-partials]").textContent);
  var live = figure.querySelector(".live"), readout = figure.querySelector("[data-readout]");
  var shown = { measured: true, model: true, partials: true };
  function colour(name) { return getComputedStyle(document.documentElement).getPropertyValue(name).trim(); }
  function at(curve, f) {
    var k = Math.round(f / curve.step);
    return k >= 0 && k < curve.level.length && curve.level[k] !== null ? curve.level[k] / 10 : null;
  }
  var base = data.measured || data.model, x = [], columns = [x];
  if (base) for (var k = 0; k < base.level.length; k++) x.push(k * base.step);
  else for (k = 0; k <= 2000; k++) x.push(data.high_hz * k / 2000);
  ["measured", "model"].forEach(function (name) {
    if (data[name]) columns.push(x.map(function (f) { return at(data[name], f); }));
  });
  if (!base) columns.push(x.map(function () { return null; }));

  var top = -Infinity, low = Infinity;
  columns.slice(1).forEach(function (c) { c.forEach(function (v) { if (v !== null) { top = Math.max(top, v); low = Math.min(low, v); } }); });
  partials.forEach(function (p) { if ("l" in p) { top = Math.max(top, p.l); low = Math.min(low, p.l - 10); } });
  low = Math.max(low, top - 110);
  var levels = [10 * Math.floor(low / 10), 10 * Math.ceil((top + 4) / 10)];

  function draw_partials(u) {
    if (!shown.partials) return;
    var ctx = u.ctx, ratio = window.devicePixelRatio || 1, box = u.bbox, taken = [];
    ctx.save();
    ctx.beginPath();
    ctx.rect(box.left, box.top - 14 * ratio, box.width, box.height + 14 * ratio);
    ctx.clip();
    ctx.strokeStyle = ctx.fillStyle = colour("--accent");
    ctx.lineWidth = 1.5 * ratio;
    ctx.font = 11 * ratio + "px system-ui,sans-serif";
    ctx.textAlign = "center";
    partials.slice().sort(function (a, b) { return b.l - a.l; }).forEach(function (p) {
      if (!("l" in p) || p.f < u.scales.x.min || p.f > u.scales.x.max) return;
      var px = u.valToPos(p.f, "x", true), py = u.valToPos(p.l, "y", true);
      ctx.beginPath();
      ctx.moveTo(px, box.top + box.height);
      ctx.lineTo(px, py);
      ctx.stroke();
      ctx.beginPath();
      ctx.arc(px, py, 3 * ratio, 0, 2 * Math.PI);
      ctx.fill();
      if (taken.some(function (other) { return Math.abs(other - px) < 48 * ratio; })) return;
      taken.push(px);
      ctx.fillText(p.f.toFixed(p.f < 1000 ? 1 : 0), px, py - 6 * ratio);
    });
    ctx.restore();
  }
  function read(u) {
    if (u.cursor.left === null || u.cursor.left < 0) { readout.textContent = ""; return; }
    var f = u.posToVal(u.cursor.left, "x"), words = [f.toFixed(1) + " Hz"];
    ["measured", "model"].forEach(function (name) {
      var level = data[name] && shown[name] ? at(data[name], f) : null;
      if (level !== null) words.push(name + " " + level.toFixed(1).replace("-", "−") + " dB");
    });
    var near = null, reach = 12 * (u.scales.x.max - u.scales.x.min) / Math.max(1, u.over.clientWidth);
    partials.forEach(function (p) {
      var away = Math.abs(p.f - f);
      if (away < reach && (!near || away < Math.abs(near.f - f))) near = p;
    });
    if (near) words.push("partial " + near.f.toFixed(2) + " Hz" + (near.n ? " (" + near.n + ")" : "") +
      (near.d > 0 ? ", 60 dB in " + (Math.log(1000) / near.d).toPrecision(3) + " s" : ""));
    readout.textContent = words.join(", ");
  }
  function axis(label) {
    return { label: label, stroke: colour("--muted"), grid: { stroke: colour("--line"), width: 1 }, ticks: { stroke: colour("--line") },
      font: "12px system-ui,sans-serif", labelFont: "12px system-ui,sans-serif", labelSize: 22 };
  }
  var series = [{}];
  if (data.measured) series.push({ label: "measured", stroke: colour("--muted"), width: 1, points: { show: false } });
  if (data.model) series.push({ label: "model", stroke: colour("--model"), width: 1, points: { show: false } });
  if (!base) series.push({ label: "", points: { show: false } });
  function width() { return Math.max(240, figure.clientWidth - 34); }
  function height() { return width() < 500 ? 260 : 340; }

  live.hidden = false;
  figure.classList.add("live");
  var plot = new uPlot({
    width: width(), height: height(), legend: { show: false }, cursor: { drag: { x: true, y: false }, points: { show: false } },
    scales: { x: { time: false, min: 0, max: data.high_hz }, y: { range: levels } },
    axes: [axis("Frequency [Hz]"), axis(data.axis)], series: series,
    hooks: {
      draw: [draw_partials], setCursor: [read],
      setScale: [function (u, key) {
        if (key !== "x" || u.scales.x.min == null) return;
        figure.setAttribute("data-range-hz", u.scales.x.min.toPrecision(7) * 1 + " " + u.scales.x.max.toPrecision(7) * 1);
      }]
    }
  }, columns, live);

  function show(min, max) {
    var span = Math.max(5, Math.min(max - min, data.high_hz)), from = Math.max(0, Math.min(min, data.high_hz - span));
    plot.setScale("x", { min: from, max: from + span });
  }
  function zoom(factor, centre) {
    var s = plot.scales.x, f = centre === undefined ? (s.min + s.max) / 2 : centre;
    show(f - (f - s.min) * factor, f + (s.max - f) * factor);
  }
  plot.over.addEventListener("wheel", function (event) {
    event.preventDefault();
    zoom(event.deltaY < 0 ? 0.8 : 1.25, plot.posToVal(event.clientX - plot.over.getBoundingClientRect().left, "x"));
  }, { passive: false });
  plot.over.addEventListener("dblclick", function () { show(0, data.high_hz); });
  figure.addEventListener("click", function (event) {
    var button = event.target.closest("button");
    if (!button) return;
    if (button.dataset.action === "zoom-in") zoom(0.5);
    if (button.dataset.action === "zoom-out") zoom(2);
    if (button.dataset.action === "zoom-reset") show(0, data.high_hz);
    var layer = button.dataset.layer;
    if (!layer) return;
    shown[layer] = !shown[layer];
    button.setAttribute("aria-pressed", String(shown[layer]));
    plot.series.forEach(function (one, i) { if (i > 0 && one.label === layer) plot.setSeries(i, { show: shown[layer] }); });
    plot.redraw();
  });
  if (window.ResizeObserver) new ResizeObserver(function () { plot.setSize({ width: width(), height: height() }); }).observe(figure);
});
