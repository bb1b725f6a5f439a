// Draws moving figures from numbers on a canvas. What the numbers are is told in player.py.
const clamp = (x, low, high) => Math.min(Math.max(x, low), high);

async function unpack(text) {                    // base64 of a zlib stream -> bytes
  const packed = new Blob([Uint8Array.from(atob(text), letter => letter.charCodeAt(0))]);
  return new Uint8Array(await new Response(
    packed.stream().pipeThrough(new DecompressionStream("deflate"))).arrayBuffer());
}

// The inverse of player._numbers: points in steps (frames, joints + 1, 3), the last one of a frame the middle that the
// camera follows, NaN where a joint is missing.
async function decode(figure) {
  const {frames, parents, feet} = figure, joints = parents.length, width = 3 * (joints + 1), count = frames * width;
  const bytes = await unpack(figure.data), points = new Float32Array(count);
  for (let channel = 0, i = 0; channel < width; channel++) {
    const joint = Math.floor(channel / 3), parent = joint < joints && parents[joint] < joint ? parents[joint] : -1;
    for (let t = 0, place = 0, change = 0; t < frames; t++, i++) {
      const z = bytes[i] | bytes[count + i] << 8 | bytes[2 * count + i] << 16 | bytes[3 * count + i] << 24;
      place += change += (z >>> 1) ^ -(z & 1);
      points[t * width + channel] = place + (parent < 0 ? 0 : points[t * width + 3 * parent + channel % 3]);
    }
  }
  const bit = (start, i) => bytes[start + (i >> 3)] >> (7 - (i & 7)) & 1, flags = 4 * count;
  for (let i = 0; i < frames * joints; i++)
    if (bit(flags, i)) for (let a = 0; a < 3; a++) points[3 * (i + Math.floor(i / joints)) + a] = NaN;
  const standing = flags + Math.ceil(frames * joints / 8);
  return {...figure, points, width, joints, end: (frames - 1) / figure.fps,
    bones: parents.map((parent, joint) => [parent, joint]).filter(bone => bone[0] >= 0),
    planted: (t, k) => bit(standing, t * feet.length + k)};
}

// The points of a figure at a time between two frames; past either end, those of the last one there.
function pose({points, width, frames, fps, step}, time) {
  const x = clamp(time * fps, 0, frames - 1), a = width * Math.floor(x + 1e-6), w = x % 1;
  const row = new Float64Array(width);
  for (let i = 0; i < width; i++) {
    const p = points[a + i];
    row[i] = step * (w > 1e-6 && w < 1 - 1e-6 ? p + w * (points[a + width + i] - p) : p);
  }
  return row;
}

function mixed(one, other, share) {              // two colours #rrggbb
  const part = (colour, i) => parseInt(colour.slice(i, i + 2), 16);
  return "#" + [1, 3, 5].map(i => Math.round(part(one, i) * (1 - share) + part(other, i) * share)
    .toString(16).padStart(2, "0")).join("");
}

async function start(host, markup, data) {
  host.dataset.ready = "";
  const root = host.attachShadow({mode: "open"});
  root.innerHTML = markup;
  const find = name => root.querySelector(name), scene = find(".scene"), stands = find(".stands");
  const slider = find("input"), still = matchMedia("(prefers-reduced-motion: reduce)");
  const figures = await Promise.all(data.figures.map(decode)), many = figures.length > 1;
  const finest = figures.reduce((a, b) => b.fps > a.fps ? b : a).fps;
  const duration = Math.max(...figures.map(f => f.end)), last = Math.round(duration * finest);
  const reach = Math.max(...figures.map(f => f.reach));
  const camera = {}, fingers = new Map();
  let time = 0, playing = duration > 0 && !still.matches, visible = false, stamp = null, asked = false;
  let beside = many, onion = false, colours = {};

  const frame = figure => Math.min(Math.floor(time * figure.fps + 1e-6), figure.frames - 1);
  const centre = (figure, t) => [...pose(figure, t).slice(-3)];
  const together = () => figures.map(f => centre(f, time)).reduce(
    (sum, one) => sum.map((x, axis) => x + one[axis] / figures.length), [0, 0, 0]);
  const spread = () => {                         // how far apart the figures are, for a view of all
    const middle = together(), from = f => Math.hypot(...centre(f, time).map((x, a) => x - middle[a]));
    return Math.min(2 * reach, Math.max(...figures.map(from)));
  };

  // ---- from the world to the picture ----
  function project(view, x, y, z) {              // -> across, down, nearness in lengths; NaN behind the camera
    const dx = x - view.focus[0], dy = y - view.focus[1], dz = z - view.focus[2];
    const ahead = dx * Math.sin(camera.turn) + dz * Math.cos(camera.turn);
    const near = ahead * Math.cos(camera.tilt) + dy * Math.sin(camera.tilt), away = 6 * reach - near;
    const s = away > 0.5 * reach ? view.scale * 6 * reach / away : NaN;
    return [view.x + s * (dx * Math.cos(camera.turn) - dz * Math.sin(camera.turn)),
      view.y - s * (dy * Math.cos(camera.tilt) - ahead * Math.sin(camera.tilt)), near];
  }
  function line(pen, view, points) {             // through points of the world, broken where one cannot be seen
    pen.beginPath();
    let down = false;
    for (const point of points) {
      const [x, y] = project(view, ...point);
      if (x === x) pen[down ? "lineTo" : "moveTo"](x, y);
      down = x === x;
    }
  }
  function views(width, height) {                // one for all, or one each in as many columns as give most room
    const groups = beside ? figures.map(f => [f]) : [figures], size = beside ? reach : reach + spread();
    const room = columns => Math.min(width / columns / 1.5, height / Math.ceil(groups.length / columns) / 2.5) / size;
    let columns = 1;
    for (let c = 2; c <= groups.length; c++) if (room(c) > room(columns)) columns = c;
    const wide = width / columns, high = height / Math.ceil(groups.length / columns);
    return groups.map((group, n) => {
      const left = wide * (n % columns), top = high * Math.floor(n / columns);
      return {group, left, top, wide, high, x: left + wide / 2, y: top + high * 0.53,
        scale: room(columns) * camera.zoom, focus: beside ? centre(group[0], time) : together()};
    });
  }

  // ---- drawing ----
  function floor(pen, view) {
    const size = data.square, radius = Math.min(4 * reach, 40 * size), [x, , z] = view.focus;
    pen.strokeStyle = colours.floor;
    pen.lineWidth = 1;
    for (const [here, at] of [[x, (c, d) => [c, 0, z + d]], [z, (c, d) => [x + d, 0, c]]])
      for (let c = Math.ceil((here - radius) / size) * size; c <= here + radius; c += size) {
        const half = Math.sqrt(Math.max(0, radius ** 2 - (c - here) ** 2));
        line(pen, view, [-1, -0.5, 0, 0.5, 1].map(k => at(c, k * half)));
        pen.stroke();
      }
  }
  function way(pen, view, figure) {              // of the middle over the floor, ten seconds before and after
    const now = Math.round(10 * time), points = [];
    for (let k = Math.max(0, now - 100); k <= now + 100; k++) {        // in tenths, so that it lies still
      const [x, , z] = centre(figure, Math.min(k / 10, figure.end));
      points.push([x, 0, z]);
    }
    pen.strokeStyle = mixed(figure.shade, colours.paper, 0.5);
    pen.lineWidth = 1.5;
    line(pen, view, points);
    pen.stroke();
  }
  function body(pen, view, figure, t, ghost) {
    const at = pose(figure, t);
    const seen = figure.parents.map((_, j) => project(view, at[3 * j], at[3 * j + 1], at[3 * j + 2]));
    const thick = Math.max(1.5, 0.05 * figure.reach * view.scale * Math.min(1, Math.sqrt(30 / figure.joints)));
    const depth = project(view, ...at.slice(-3))[2];
    const pale = near => ghost || clamp(0.2 - 0.35 * (near - depth) / figure.reach, 0, 0.5);
    const long = ([a, b]) => Math.hypot(...[0, 1, 2].map(axis => at[3 * a + axis] - at[3 * b + axis]));
    // A longer bone leads to a root that was left behind.
    const strokes = figure.bones.filter(bone => long(bone) < 2.5 * figure.reach)
      .map(([a, b]) => ({a: seen[a], b: seen[b], near: (seen[a][2] + seen[b][2]) / 2}));
    if (!figure.bones.length) seen.forEach(p => strokes.push({a: p, b: p, near: p[2]}));
    if (figure.head !== null) {
      const [a, b] = [figure.parents[figure.head], figure.head].map(j => seen[Math.max(j, 0)]);
      const r = 0.1 * figure.reach * view.scale, up = 0.7 * r / (Math.hypot(b[0] - a[0], b[1] - a[1]) || 1);
      strokes.push({ball: r, a: [b[0] + up * (b[0] - a[0]), b[1] + up * (b[1] - a[1])], near: b[2]});
    }
    pen.lineCap = "round";
    for (const {a, b, ball, near} of strokes.filter(s => s.near === s.near).sort((p, q) => p.near - q.near))
      for (const edge of ghost ? [0] : [Math.min(2.5, thick / 2), 0]) {    // a rim tells which is in front
        pen.strokeStyle = pen.fillStyle = mixed(figure.shade, colours.paper, edge ? 1 : pale(near));
        pen.lineWidth = (ghost ? 0.6 : 1) * thick + edge;
        pen.beginPath();
        if (ball !== undefined) { pen.arc(a[0], a[1], ball + edge / 2, 0, 7); pen.fill(); }
        else { pen.moveTo(a[0], a[1]); pen.lineTo(b[0], b[1] + 0.01); pen.stroke(); }
      }
  }
  function feet(pen, view, figure) {             // a disc on the floor below each foot that stands
    const at = pose(figure, time), r = 0.08 * figure.reach, turns = [...Array(17).keys()].map(i => i * Math.PI / 8);
    figure.feet.forEach((joint, k) => {
      if (!figure.planted(frame(figure), k)) return;
      const [x, y, z] = at.slice(3 * joint, 3 * joint + 3), low = y < 0.2 * figure.reach ? 0 : y;
      line(pen, view, turns.map(turn => [x + r * Math.cos(turn), low, z + r * Math.sin(turn)]));
      pen.fillStyle = mixed(figure.shade, colours.paper, 0.45);
      pen.fill();
    });
  }
  function names(pen, view) {
    pen.textBaseline = "top";
    view.group.forEach((figure, n) => {
      const now = frame(figure), first = now * figure.width;
      const lost = figure.parents.filter((_, j) => Number.isNaN(figure.points[first + 3 * j])).length;
      const notes = [figures.some(f => f.fps !== figure.fps) && `frame ${now}`,
        lost && `${lost} joint${lost > 1 ? "s" : ""} missing`,
        many && time > figure.end + 1e-6 && "ended"].filter(Boolean).join(", ");
      const y = view.top + 4 + 20 * n, fits = text => pen.measureText(text).width <= view.wide - 26;
      pen.fillStyle = figure.shade;
      pen.fillRect(view.left + 4, y + 2, 11, 11);
      let name = figure.name, tail = notes && ` (${notes})`;
      while (name && !fits(name + tail)) name = name.replace(/.…?$/su, "") && name.replace(/.…?$/su, "…");
      pen.fillStyle = colours.ink;
      pen.fillText(name + tail, view.left + 20, y);
    });
  }
  function sized(canvas, height) {               // a pen for a canvas in the page's pixels, wiped
    const ratio = devicePixelRatio || 1, pen = canvas.getContext("2d");
    const [wide, high] = [canvas.clientWidth, height].map(length => Math.round(length * ratio));
    if (canvas.width !== wide || canvas.height !== high) Object.assign(canvas, {width: wide, height: high});
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, wide, high);
    return pen;
  }
  function draw() {
    const width = scene.clientWidth, height = scene.clientHeight, pen = sized(scene, height);
    const style = getComputedStyle(find(".player")), index = Math.floor(time * finest + 1e-6);
    for (const name of ["ink", "quiet", "paper", "floor"]) colours[name] = style.getPropertyValue("--" + name).trim();
    for (const f of figures) f.shade = mixed(f.colour, "#ffffff", Number(style.getPropertyValue("--lift")));
    pen.font = "14px system-ui, sans-serif";
    for (const view of views(width, height)) {
      pen.save();
      pen.beginPath();
      pen.rect(view.left, view.top, view.wide, view.high);
      pen.clip();
      floor(pen, view);
      for (const figure of view.group) way(pen, view, figure);
      for (const figure of view.group) feet(pen, view, figure);
      for (const figure of onion ? view.group : [])
        for (const k of [-4, 4, -3, 3, -2, 2, -1, 1]) {
          const t = time + 0.2 * k;
          if (t >= 0 && t <= figure.end) body(pen, view, figure, t, 0.55 + 0.09 * Math.abs(k));
        }
      for (const figure of view.group) body(pen, view, figure, time, 0);
      names(pen, view);
      pen.restore();
    }
    pen.font = "12px system-ui, sans-serif";
    pen.fillStyle = colours.quiet;
    pen.textBaseline = "bottom";
    pen.fillText(`floor squares: ${data.square} ${data.unit}`, 4, height - 2);
    slider.value = Math.round(time * finest);
    find("output").textContent = `${time.toFixed(2)} of ${duration.toFixed(2)} s, frame ${index} of ${last}`;
    find(".play").textContent = playing ? "Pause" : "Play";
    if (!playing) slider.setAttribute("aria-valuetext", find("output").textContent);
  }
  function drawStands() {                        // a row for each foot: when it stands
    const rows = figures.flatMap(f => f.feet.map((_, k) => [f, k])), high = 4 * rows.length;
    stands.hidden = !rows.length || !duration;
    stands.style.height = high + "px";
    const pen = sized(stands, high);
    rows.forEach(([figure, k], row) => {
      pen.fillStyle = figure.shade;
      for (let x = 0; x < stands.clientWidth; x++) {
        const t = Math.round(x / stands.clientWidth * duration * figure.fps);
        if (t < figure.frames && figure.planted(t, k)) pen.fillRect(x, 4 * row, 1, 3);
      }
    });
  }

  // ---- time ----
  function tick(now) {
    asked = false;
    if (playing && stamp !== null) {
      time += Math.min((now - stamp) / 1000, 0.25) * parseFloat(find("select").value);
      if (time > duration) time %= duration;
    }
    stamp = playing ? now : null;
    draw();
    if (playing && visible) ask();
  }
  const ask = () => { if (!asked) { asked = true; requestAnimationFrame(tick); } };
  const play = on => { playing = on && duration > 0; stamp = null; ask(); };
  const go = index => { play(false); time = clamp(index, 0, last) / finest; };
  const reset = () => { Object.assign(camera, {turn: -0.9, tilt: 0.25, zoom: 1}); ask(); };
  function look(turn, tilt, nearer) {
    camera.turn -= turn;
    camera.tilt = clamp(camera.tilt + tilt, -0.3, 1.57);
    camera.zoom = clamp(camera.zoom * nearer, 0.1, 20);
    ask();
  }

  // ---- what is pressed, dragged and turned ----
  const toggle = (name, change) => find(name).addEventListener("click", event => {
    event.target.setAttribute("aria-pressed", change());
    ask();
  });
  toggle(".beside", () => beside = !beside);
  toggle(".onion", () => onion = !onion);
  find(".play").onclick = () => play(!playing);
  find(".reset").onclick = reset;
  slider.oninput = () => go(Number(slider.value));
  root.addEventListener("keydown", event => {
    const now = Math.round(time * finest), second = Math.round(finest), turn = 0.1, on = event.target.localName;
    const keys = event.shiftKey ? {
      ArrowLeft: () => look(-turn, 0, 1), ArrowRight: () => look(turn, 0, 1),
      ArrowUp: () => look(0, turn, 1), ArrowDown: () => look(0, -turn, 1),
    } : {
      ArrowLeft: () => go(now - 1), ArrowRight: () => go(now + 1), Home: () => go(0), End: () => go(last),
      PageUp: () => go(now + second), PageDown: () => go(now - second), 0: reset,
    };
    for (const [key, nearer] of [["+", 1.25], ["=", 1.25], ["-", 0.8]]) keys[key] = () => look(0, 0, nearer);
    if (on !== "button" && on !== "summary") keys[" "] = () => play(!playing);
    if (!keys[event.key] || on === "select" || event.ctrlKey || event.altKey || event.metaKey) return;
    keys[event.key]();
    event.preventDefault();
    event.stopPropagation();                     // a notebook has keys of its own
  });
  scene.onpointerdown = event => {
    fingers.set(event.pointerId, [event.clientX, event.clientY]);
    scene.setPointerCapture(event.pointerId);
  };
  scene.onpointermove = event => {
    if (!fingers.has(event.pointerId)) return;
    const apart = () => { const [a, b] = fingers.values(); return Math.hypot(a[0] - b[0], a[1] - b[1]) || 1; };
    const [x, y] = fingers.get(event.pointerId), two = fingers.size === 2, before = two && apart();
    fingers.set(event.pointerId, [event.clientX, event.clientY]);
    if (two) look(0, 0, apart() / before);
    else look((event.clientX - x) / 120, (event.clientY - y) / 120, 1);
  };
  scene.onpointerup = scene.onpointercancel = event => fingers.delete(event.pointerId);
  scene.addEventListener("wheel", event => {
    if (!host.dataset.alone && !event.ctrlKey && root.activeElement !== scene) return;
    look(0, 0, Math.exp(-clamp(event.deltaY, -100, 100) / 400));
    event.preventDefault();
  }, {passive: false});

  // ---- the page around it ----
  for (const [name, text] of [["h1", data.title], [".caption", data.caption]]) {
    find(name).textContent = text;
    find(name).hidden = !text;
  }
  const everybody = figures.map(f => f.name).join(", ");
  scene.setAttribute("aria-label", `${everybody}: moving figures, ${duration.toFixed(2)} seconds`);
  find(".beside").hidden = !many;
  find(".beside").setAttribute("aria-pressed", beside);
  find(".play").disabled = slider.disabled = !duration;
  slider.max = last;
  const again = () => { draw(); drawStands(); };
  new ResizeObserver(again).observe(host);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", again);
  reset();
  again();
  new IntersectionObserver(seen => {             // out of sight it rests
    visible = seen.at(-1).isIntersecting;
    stamp = null;
    host.dataset.ready = "yes";
    ask();
  }).observe(host);
}
