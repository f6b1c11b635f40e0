// A body that turns and moves in its modes (three.js). Its surface comes as whole numbers: 32767 is half its extent, 127 the largest
// motion of a mode.
"use strict";
klang.all('[data-figure="shape"]').forEach(function (figure) {
  var canvas = figure.querySelector("canvas"), choice = figure.querySelector("[data-modes]"), name = figure.querySelector("[data-name]");
  var toggle = figure.querySelector('[data-action="animate"]'), view = null, visible = false, pending = false;
  var moving = !(window.matchMedia && matchMedia("(prefers-reduced-motion: reduce)").matches);

  function bytes(text) { return Uint8Array.from(atob(text), function (c) { return c.charCodeAt(0); }).buffer; }
  function say() {
    name.textContent = choice.options[choice.selectedIndex].textContent;
    toggle.setAttribute("aria-pressed", String(moving));
  }
  function make() {
    var gl = canvas.getContext("webgl2", { antialias: true, alpha: true });
    if (!gl) { canvas.parentNode.textContent = "Turning shapes need WebGL; the pictures below show the same."; return null; }
    var data = JSON.parse(figure.querySelector("script[data-body]").textContent);
    var whole = new Int16Array(bytes(data.points)), points = new Float32Array(whole.length);
    for (var i = 0; i < whole.length; i++) points[i] = whole[i] / 32767;
    var geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(points, 3));
    var triangles = bytes(data.triangles);
    geometry.setIndex(new THREE.BufferAttribute(data.wide ? new Uint32Array(triangles) : new Uint16Array(triangles), 1));
    geometry.computeVertexNormals();
    var motion = new THREE.BufferAttribute(new Float32Array(points.length), 3);
    var shade = new THREE.BufferAttribute(new Float32Array(points.length / 3), 1);
    geometry.setAttribute("motion", motion);
    geometry.setAttribute("shade", shade);
    geometry.computeBoundingSphere();
    var material = new THREE.ShaderMaterial({
      side: THREE.DoubleSide, uniforms: { amount: { value: 0 }, signed: { value: 1 } },
      vertexShader: "attribute vec3 motion; attribute float shade; uniform float amount; varying float s; varying vec3 p;" +
        "void main(){ s = shade; vec4 q = modelViewMatrix * vec4(position + amount * motion, 1.0); p = q.xyz; gl_Position = projectionMatrix * q; }",
      fragmentShader: "uniform float signed; varying float s; varying vec3 p;" +
        "void main(){ vec3 n = normalize(cross(dFdx(p), dFdy(p))); float light = 0.45 + 0.55 * abs(n.z);" +
        "vec3 c = s > 0.0 ? mix(vec3(0.88, 0.87, 0.85), vec3(0.66, 0.12, 0.18), s) : mix(vec3(0.88, 0.87, 0.85), vec3(0.05, 0.33, 0.58), -s);" +
        "float line = signed * (1.0 - smoothstep(0.8, 1.6, abs(s) / max(fwidth(s), 1e-5)));" +
        "gl_FragColor = vec4(mix(c * light, vec3(0.08), line), 1.0); }"
    });
    var scene = new THREE.Scene(), camera = new THREE.PerspectiveCamera(28, 1, 0.05, 50);
    scene.add(new THREE.Mesh(geometry, material));
    var size = [0, 0, 0];
    for (i = 0; i < points.length; i++) size[i % 3] = Math.max(size[i % 3], Math.abs(points[i]));
    var long = size.indexOf(Math.max.apply(null, size)), up = long === 2 ? 0 : 2;
    camera.up.set(up === 0 ? 1 : 0, 0, up === 2 ? 1 : 0);
    var eye = [1.2, 1.2, 1.2];
    eye[long] = 0.9;
    eye[3 - long - up] = -3.2;
    camera.position.set(eye[0], eye[1], eye[2]).setLength(3.7);
    var renderer = new THREE.WebGLRenderer({ canvas: canvas, context: gl, antialias: true, alpha: true });
    renderer.setPixelRatio(Math.min(2, window.devicePixelRatio || 1));
    var controls = new THREE.OrbitControls(camera, canvas);
    controls.enablePan = false;
    controls.addEventListener("change", ask);
    function show(mode) {
      var raw = new Int8Array(bytes(data.modes[mode].shape)), normals = geometry.attributes.normal.array, largest = 0, along = 0;
      for (var v = 0; v < shade.count; v++) {
        var dot = 0, square = 0;
        for (var a = 0; a < 3; a++) {
          var u = raw[3 * v + a] / 127;
          motion.array[3 * v + a] = u;
          dot += u * normals[3 * v + a];
          square += u * u;
        }
        shade.array[v] = dot;
        largest = Math.max(largest, Math.sqrt(square));
        along = Math.max(along, Math.abs(dot));
      }
      var tangential = along < 0.2 * largest;
      for (v = 0; v < shade.count; v++) {
        if (tangential) shade.array[v] = Math.hypot(motion.array[3 * v], motion.array[3 * v + 1], motion.array[3 * v + 2]);
        shade.array[v] /= tangential ? largest : along;
      }
      material.uniforms.signed.value = tangential ? 0 : 1;
      motion.needsUpdate = shade.needsUpdate = true;
    }
    function resize() {
      var width = canvas.parentNode.clientWidth, height = Math.round(Math.min(420, Math.max(220, 0.5 * width)));
      renderer.setSize(width, height, false);
      canvas.style.width = width + "px";
      canvas.style.height = height + "px";
      camera.aspect = width / height;
      camera.fov = camera.aspect < 1.4 ? 40 : 28;
      camera.updateProjectionMatrix();
    }
    resize();
    if (window.ResizeObserver) new ResizeObserver(function () { resize(); ask(); }).observe(canvas.parentNode);
    return { show: show, draw: function (phase) { material.uniforms.amount.value = 0.16 * Math.sin(phase); renderer.render(scene, camera); } };
  }
  var began = performance.now(), still = Math.PI / 2;
  function frame(now) {
    pending = false;
    if (!view || !visible) return;
    view.draw(moving ? (now - began) / 320 : still);
    if (moving) ask();
  }
  function ask() {
    if (pending) return;
    pending = true;
    requestAnimationFrame(frame);
  }
  function come(on) {
    visible = on;
    if (on && view === null) {
      view = make() || false;
      if (view) view.show(choice.selectedIndex);
    }
    if (on) ask();
  }
  choice.addEventListener("change", function () { say(); if (view) view.show(choice.selectedIndex); ask(); });
  toggle.addEventListener("click", function () { moving = !moving; say(); ask(); });
  say();
  if (window.IntersectionObserver) new IntersectionObserver(function (entries) { come(entries[entries.length - 1].isIntersecting); }).observe(figure);
  else come(true);
});
