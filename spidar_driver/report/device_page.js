'use strict';
// Sections and the border in 3-D of every device of the page, on canvases in the colours of the theme.
const devices = JSON.parse(document.getElementById('data').textContent);
const root = document.documentElement, shown = document.getElementById('shown'), scale = document.getElementById('scale');
const colour = name => getComputedStyle(root).getPropertyValue('--' + name).trim();
const UNITS = { force: 'N', isotropy: '', stiffness: 'N/m' };
const regionOf = canvas => devices[canvas.dataset.device].regions.find(region => region.kind === canvas.dataset.region);

// Greatest sample of all devices and regions: two pages side by side share one scale.
const most = name => Math.max(1e-9, ...devices.flatMap(device => device.regions.flatMap(region => region.sections.flatMap(s => s[name]))));

function context(canvas, height) {
  const width = canvas.clientWidth, ratio = window.devicePixelRatio || 1;
  canvas.width = width * ratio;
  canvas.height = height * ratio;
  canvas.style.height = height + 'px';
  const pen = canvas.getContext('2d');
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  pen.font = '12px system-ui, sans-serif';
  return pen;
}

function roundStep(span, count) {
  const power = 10 ** Math.floor(Math.log10(span / count));
  return [1, 2, 5, 10].map(factor => factor * power).find(step => step * count >= span);
}

function blend(share) {
  const parse = name => colour(name).match(/[0-9a-f]{2}/gi).map(hex => parseInt(hex, 16));
  const low = parse('soft'), high = parse('c0');
  return `rgb(${low.map((value, i) => Math.round(value + share * (high[i] - value))).join(',')})`;
}

function drawAxes(pen, place, box, [u, v], half, centre, unit) {
  pen.strokeStyle = colour('ink');
  pen.fillStyle = colour('ink');
  pen.lineWidth = 1;
  pen.strokeRect(...box);
  const step = roundStep(2 * Math.max(half[u], half[v]), 6);
  const ticks = axis => {
    const found = [];
    for (let at = Math.ceil((centre[axis] - half[axis]) / step); at * step <= centre[axis] + half[axis] + 1e-9; ++at) found.push(at * step);
    return found;
  };
  const label = value => String(Number(value.toPrecision(6))).replace('-', '−');
  pen.textAlign = 'center';
  for (const tick of ticks(u)) {
    const [x] = place(tick, 0);
    pen.fillRect(x, box[1] + box[3], 1, 4);
    pen.fillText(label(tick), x, box[1] + box[3] + 16);
  }
  pen.textAlign = 'right';
  for (const tick of ticks(v)) {
    const [, y] = place(0, tick);
    pen.fillRect(box[0] - 4, y, 4, 1);
    pen.fillText(label(tick), box[0] - 7, y + 4);
  }
  pen.textAlign = 'center';
  pen.fillText(`${'xyz'[u]} [${unit}]`, box[0] + box[2] / 2, box[1] + box[3] + 32);
  pen.save();
  pen.translate(box[0] - 44, box[1] + box[3] / 2);
  pen.rotate(-Math.PI / 2);
  pen.fillText(`${'xyz'[v]} [${unit}]`, 0, 0);
  pen.restore();
}

function drawSection(canvas) {
  const region = regionOf(canvas), section = region.sections[canvas.dataset.section];
  const u = (section.across + 1) % 3, v = (section.across + 2) % 3, { centre, half } = region.searched;
  const width = canvas.clientWidth, left = 58, room = width - left - 12;
  const pixels = Math.min(room / (2 * half[u]), 420 / (2 * half[v])), high = 2 * half[v] * pixels;
  const pen = context(canvas, high + 50), middle = [left + room / 2, 8 + high / 2];
  const place = (a, b) => [middle[0] + pixels * (a - centre[u]), middle[1] - pixels * (b - centre[v])];
  if (shown.value === 'region') {
    for (const [name, fill] of [['inside', 'c0'], ['undecided', 'slip']]) {
      pen.fillStyle = colour(fill);
      for (const [a, b, w, h] of section[name]) {
        const [x, y] = place(a, b + h);
        pen.fillRect(x, y, w * pixels + 0.3, h * pixels + 0.3);
      }
    }
  } else {
    const n = section.samples, top = most(shown.value);
    section[shown.value].forEach((value, i) => {
      const [x, y] = place(centre[u] - half[u] + 2 * half[u] * (i % n) / n, centre[v] - half[v] + 2 * half[v] * (Math.floor(i / n) + 1) / n);
      pen.fillStyle = blend(value / top);
      pen.fillRect(x, y, 2 * half[u] * pixels / n + 0.4, 2 * half[v] * pixels / n + 0.4);
    });
  }
  const box = [middle[0] - pixels * half[u], 8, 2 * pixels * half[u], high];
  drawAxes(pen, place, box, [u, v], half, centre, region.kind === 'turns' ? '°' : 'mm');
  pen.strokeStyle = colour('ink');
  pen.lineWidth = 1.5;
  if (region.homeBall.half[0] > 0 && shown.value === 'region') {
    pen.beginPath();
    pen.arc(...place(0, 0), pixels * region.homeBall.half[0], 0, 7);
    pen.stroke();
  }
  if (region.kind === 'translations')
    for (const string of devices[canvas.dataset.device].strings) {
      const [x, y] = place(string.exit[u], string.exit[v]);
      pen.fillStyle = colour('c1');
      pen.beginPath();
      pen.arc(x, y, 4, 0, 7);
      pen.fill();
    }
}

// z up; a turn about z, then one about the picture's own horizontal. Nearer points are drawn later and darker.
function drawSpace(canvas) {
  const region = regionOf(canvas), device = devices[canvas.dataset.device], view = canvas.view ||= { turn: 0.6, lift: 0.45 };
  const height = Math.min(canvas.clientWidth, 420), pen = context(canvas, height), { centre, half } = region.searched;
  const reach = Math.hypot(...half), pixels = 0.47 * Math.min(height, canvas.clientWidth) / reach;
  const [ct, st, cl, sl] = [Math.cos(view.turn), Math.sin(view.turn), Math.cos(view.lift), Math.sin(view.lift)];
  const place = p => {
    const [x, y, z] = p.map((value, i) => value - centre[i]), across = -st * x + ct * y, deep = ct * x + st * y;
    return [canvas.clientWidth / 2 + pixels * across, height / 2 - pixels * (cl * z - sl * deep), cl * deep + sl * z];
  };
  const line = (a, b, name, wide) => {
    const [p, q] = [place(a), place(b)];
    pen.strokeStyle = colour(name);
    pen.lineWidth = wide;
    pen.beginPath();
    pen.moveTo(p[0], p[1]);
    pen.lineTo(q[0], q[1]);
    pen.stroke();
  };
  for (let axis = 0; axis < 3; ++axis)
    for (const [s, t] of [[-1, -1], [-1, 1], [1, -1], [1, 1]]) {
      const end = side => centre.map((c, i) => c + half[i] * (i === axis ? side : i === (axis + 1) % 3 ? s : t));
      line(end(-1), end(1), 'faint', 1);
    }
  const size = Math.max(2, pixels * region.width * 1.2);
  const shades = Array.from({ length: 8 }, (_, i) => blend(0.3 + 0.1 * i));
  for (const [x, y, depth] of region.border.map(place).sort((a, b) => a[2] - b[2])) {
    pen.fillStyle = shades[Math.max(0, Math.min(7, Math.floor(4 * (depth / reach + 1))))];
    pen.fillRect(x - size / 2, y - size / 2, size, size);
  }
  if (region.kind === 'translations')
    for (const string of device.strings) {
      line(string.exit, string.knot, 'c1', 1.5);
      const [x, y] = place(string.exit);
      pen.fillStyle = colour('c1');
      pen.fillRect(x - 4, y - 4, 8, 8);
    }
  pen.fillStyle = colour('ink');
  for (let axis = 0; axis < 3; ++axis) {
    const end = centre.map((c, i) => c + (i === axis ? half[i] : 0));
    line(centre, end, 'ink', 1);
    const [x, y] = place(end);
    pen.fillText('xyz'[axis], x + 4, y - 4);
  }
}

function drawScale() {
  const swatch = (fill, words) => `<span><i style="background:${fill}"></i> ${words}</span>`;
  scale.innerHTML = shown.value === 'region'
    ? swatch(colour('c0'), 'inside') + swatch(colour('slip'), 'undecided') + '<span>○ ball about home</span>' + `<span style="color:${colour('c1')}">●</span> exits`
    : [0, 0.25, 0.5, 0.75, 1].map(share => swatch(blend(share), `${Number((share * most(shown.value)).toPrecision(2))} ${UNITS[shown.value]}`)).join('');
}

function drawAll() {
  drawScale();
  document.querySelectorAll('canvas.section').forEach(drawSection);
  document.querySelectorAll('canvas.space').forEach(drawSpace);
}

const setTheme = dark => { root.dataset.theme = dark ? 'dark' : 'light'; drawAll(); };
document.getElementById('theme').addEventListener('click', () => setTheme(root.dataset.theme !== 'dark'));
shown.addEventListener('change', drawAll);
window.addEventListener('resize', drawAll);
for (const canvas of document.querySelectorAll('canvas.space')) {
  const turn = (x, y) => {
    canvas.view.turn -= x;
    canvas.view.lift = Math.max(-1.5, Math.min(1.5, canvas.view.lift + y));
    drawSpace(canvas);
  };
  canvas.addEventListener('pointerdown', event => canvas.setPointerCapture(event.pointerId));
  canvas.addEventListener('pointermove', event => event.buttons && turn(0.01 * event.movementX, 0.01 * event.movementY));
  canvas.addEventListener('keydown', event => {
    const way = { ArrowLeft: [0.1, 0], ArrowRight: [-0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] }[event.key];
    if (!way) return;
    turn(...way);
    event.preventDefault();
  });
}
setTheme(window.matchMedia('(prefers-color-scheme: dark)').matches);
