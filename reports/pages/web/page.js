// What every page can do: players with play, stop and loop, a playhead on the spectrogram, single partials by ear, tables that
// sort, and everything open for the printer.
"use strict";
window.klang = (function () {
  var body = document.body, stop_synth = false, context = false;

  function all(selector, root) { return [].slice.call((root || document).querySelectorAll(selector)); }
  function say_playing(what) {
    if (what) body.setAttribute("data-playing", what);
    else body.removeAttribute("data-playing");
  }
  function sounding() { return all("audio").filter(function (a) { return !a.paused && !a.ended; }); }

  function stop_all(except) {
    if (stop_synth) stop_synth();
    all("audio").forEach(function (sound) {
      if (except && except.contains(sound)) return;
      if (!sound.paused) sound.pause();
      if (!except) sound.currentTime = 0;
    });
    if (!except) say_playing("");
  }

  // The spectrogram that belongs to a box of players follows it.
  function figure_of(box) {
    for (var next = box.nextElementSibling; next; next = next.nextElementSibling) {
      if (next.matches(".listen")) break;
      if (next.matches('[data-figure="spectrogram"]')) return next;
    }
    return false;
  }
  function move_playhead(box, time_s) {
    var figure = figure_of(box), head = figure && figure.querySelector("[data-playhead]");
    if (!head) return;
    var share = Math.min(1, time_s / parseFloat(figure.getAttribute("data-duration-s")));
    head.setAttribute("data-time-s", time_s.toFixed(3));
    all("i", head).forEach(function (line) {
      line.style.left = (parseFloat(line.dataset.left) + share * parseFloat(line.dataset.width)) + "%";
    });
  }

  function prepare_box(box) {
    var sounds = all("audio", box), compare = box.querySelector("button.compare"), heard = -1, ticking = false;
    if (!sounds.length) return;
    var names = sounds.map(function (s) { return s.parentNode.firstChild.textContent.toLowerCase(); });
    function say() {
      if (compare) compare.textContent = heard < 0 ? "Play both, compare" : "Hearing " + names[heard] + " – switch";
    }
    function lead() { return sounds.filter(function (s) { return !s.paused; })[0]; }
    function tick() {
      var sound = lead();
      ticking = !!sound;
      if (!sound) return;
      move_playhead(box, sound.currentTime);
      requestAnimationFrame(tick);
    }
    function end_compare() { heard = -1; sounds.forEach(function (s) { s.muted = false; }); say(); }
    function start(sound) { var started = sound.play(); if (started) started.catch(function () { say_playing(""); }); }

    sounds.forEach(function (sound, i) {
      sound.addEventListener("play", function () {
        stop_all(box);
        if (heard < 0) sounds.forEach(function (other) { if (other !== sound) other.pause(); });
        say_playing(heard < 0 ? names[i] : names[heard]);
        if (!ticking) { ticking = true; requestAnimationFrame(tick); }
      });
      ["pause", "ended"].forEach(function (kind) {
        sound.addEventListener(kind, function () { if (!stop_synth && !sounding().length) say_playing(""); });
      });
      ["seeked", "timeupdate"].forEach(function (kind) {
        sound.addEventListener(kind, function () { if (!sound.muted) move_playhead(box, sound.currentTime); });
      });
      sound.addEventListener("ended", function () { sounds.forEach(function (s) { s.pause(); }); end_compare(); });
    });
    if (compare) {
      compare.hidden = false;
      compare.addEventListener("click", function () {
        if (heard < 0) { heard = 0; sounds.forEach(function (s) { s.currentTime = 0; }); }
        else { heard = 1 - heard; sounds[heard].currentTime = sounds[1 - heard].currentTime; }
        sounds[heard].muted = false;
        sounds[1 - heard].muted = true;
        sounds.forEach(function (s) { if (s.paused) start(s); });
        say_playing(names[heard]);
        say();
      });
    }
    box.addEventListener("click", function (event) {
      var button = event.target.closest("button[data-action]"), action = button && button.dataset.action;
      if (action === "play") { end_compare(); start(sounds[0]); }
      if (action === "stop") { end_compare(); stop_all(); move_playhead(box, 0); }
      if (action === "loop") {
        var on = button.getAttribute("aria-pressed") !== "true";
        button.setAttribute("aria-pressed", String(on));
        sounds.forEach(function (s) { s.loop = on; });
      }
    });
    say();
    var figure = figure_of(box), plot = figure && figure.querySelector(".plot");
    if (plot) plot.addEventListener("click", function (event) {
      var lines = all("[data-playhead] i", figure), frame = plot.getBoundingClientRect();
      var at = 100 * (event.clientX - frame.left) / frame.width;
      lines.forEach(function (line, i) {
        var share = (at - parseFloat(line.dataset.left)) / parseFloat(line.dataset.width);
        var sound = sounds[Math.min(i, sounds.length - 1)];
        if (share < 0 || share > 1) return;
        sound.currentTime = Math.min(share * parseFloat(figure.getAttribute("data-duration-s")), sound.duration || 0);
        move_playhead(box, sound.currentTime);
      });
    });
  }

  // Partials by ear: a exp(-d t) cos(2 pi f t + p), by the browser's own audio.
  function play_partials(partials, what) {
    var Context = window.AudioContext || window.webkitAudioContext;
    stop_all();
    if (!Context || !partials.length) return;
    context = context || new Context();
    var slowest = Math.min.apply(Math, partials.map(function (p) { return p.d > 0 ? p.d : 3; }));
    var length_s = Math.min(8, Math.max(0.4, 6.9 / slowest)), rate = context.sampleRate;
    var buffer = context.createBuffer(1, Math.ceil(length_s * rate), rate), x = buffer.getChannelData(0), peak = 0;
    partials.forEach(function (p) {
      if (p.f >= rate / 2) return;
      for (var i = 0; i < x.length; i++) {
        var t = i / rate;
        x[i] += p.a * Math.exp(-(p.d || 0) * t) * Math.cos(2 * Math.PI * p.f * t + (p.p || 0));
      }
    });
    for (var i = 0; i < x.length; i++) peak = Math.max(peak, Math.abs(x[i]));
    for (i = 0; i < x.length; i++) x[i] *= (peak > 0 ? 0.6 / peak : 0) * Math.min(1, (x.length - i) / (0.03 * rate));
    var source = context.createBufferSource();
    source.buffer = buffer;
    source.connect(context.destination);
    var clock = setTimeout(end, 1000 * length_s + 200);
    function end() {
      clearTimeout(clock);
      source.onended = function () {};
      try { source.stop(); } catch (ignored) { /* not started */ }
      if (stop_synth === end) { stop_synth = false; say_playing(""); }
    }
    stop_synth = end;
    source.onended = end;
    say_playing(what);
    context.resume();
    source.start();
  }
  function partials_near(button) {
    for (var part = button.parentElement; part; part = part.parentElement) {
      var data = part.querySelector("script[data-partials]");
      if (data) return JSON.parse(data.textContent);
    }
    return [];
  }
  document.addEventListener("click", function (event) {
    var button = event.target.closest("button[data-action]");
    if (!button) return;
    var action = button.dataset.action, index = parseInt(button.dataset.partial, 10);
    if (action === "stop" && !button.closest(".listen")) { stop_all(); return; }
    if (action !== "hear" && action !== "hear-without") return;
    var partials = partials_near(button);
    play_partials(partials.filter(function (p, i) { return (i === index) === (action === "hear"); }),
      button.getAttribute("aria-label"));
  });

  // Tables that sort: by the cell's value where it has one, else by the number that it prints. Rows that explain the one above stay with it.
  function number_in(text) {
    var plain = text.replace(/[\u2009\u202f\u00a0]/g, "").replace(/\u2212/g, "-").trim();
    var raised = plain.replace(/\s*\u00d7\s*10([\u207b\u2070\u00b9\u00b2\u00b3\u2074-\u2079]+)/, function (all, power) {
      return "e" + power.replace(/./g, function (c) { return "-0123456789".charAt("\u207b\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079".indexOf(c)); });
    });
    var found = /^[<>+]?\s*(-?\d+(?:\.\d+)?(?:e[+-]?\d+)?)(?:\s*\/\s*(\d+(?:\.\d+)?))?/i.exec(raised);
    return found ? parseFloat(found[1]) / (found[2] ? parseFloat(found[2]) : 1) : parseFloat("none");
  }
  function value_of(cell) {
    return cell && cell.hasAttribute("data-value") ? parseFloat(cell.getAttribute("data-value")) : number_in(cell ? cell.textContent : "");
  }
  function prepare_table(table) {
    var heads = all("thead th", table), rows = table.tBodies[0];
    if (!rows || heads.length < 2 || all("tr", rows).filter(function (r) { return !r.matches(".note"); }).length < 2) return;
    heads.forEach(function (head, column) {
      if (!head.textContent.trim() || head.hasAttribute("data-plain")) return;
      head.setAttribute("aria-sort", "none");
      var button = document.createElement("button");
      button.type = "button";
      button.className = "sort";
      while (head.firstChild) button.appendChild(head.firstChild);
      head.appendChild(button);
      head.addEventListener("click", function () {
        var up = head.getAttribute("aria-sort") !== "ascending", groups = [];
        heads.forEach(function (other) { if (other.hasAttribute("aria-sort")) other.setAttribute("aria-sort", "none"); });
        head.setAttribute("aria-sort", up ? "ascending" : "descending");
        all("tr", rows).forEach(function (row) {
          if (row.matches(".note") && groups.length) { groups[groups.length - 1].rows.push(row); return; }
          var cell = row.cells[column], text = cell ? cell.textContent : "";
          groups.push({ rows: [row], text: text, number: value_of(cell), at: groups.length });
        });
        groups.sort(function (a, b) {
          var missing = isNaN(a.number) - isNaN(b.number), by_number = a.number - b.number;
          var all_words = groups.every(function (g) { return isNaN(g.number); });
          if (all_words) return (up ? 1 : -1) * a.text.localeCompare(b.text) || a.at - b.at;
          if (missing) return missing;
          return (up ? 1 : -1) * (by_number || 0) || a.at - b.at;
        });
        groups.forEach(function (group) { group.rows.forEach(function (row) { rows.appendChild(row); }); });
      });
    });
  }

  // For the printer: everything open, and the day of printing in the margin.
  function open_all() { all("details").forEach(function (part) { part.open = true; }); }
  function date_pages() {
    var style = document.createElement("style");
    style.textContent = "@page{@bottom-left{content:\"" + new Date().toISOString().slice(0, 10) + "\"}}";
    document.head.appendChild(style);
  }

  all(".listen").forEach(prepare_box);
  all("table").forEach(prepare_table);
  date_pages();
  window.addEventListener("beforeprint", open_all);
  return { all: all };
})();
