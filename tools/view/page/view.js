// The viewer's page: the picture, what the pointer and keys do to it, and the bars around it.
import { dolly, moveSun, orbit, pan } from './camera.js';
import { Controls, short } from './controls.js';

const $ = (id) => document.getElementById(id);
const canvas = $('picture');
const film = document.createElement('canvas');  // in its own pixels
let scene = null, state = { number: 0 };

// --- the server ---------------------------------------------------------------------------------

/** What the server refuses, as opposed to a server that cannot be reached. */
class Refusal extends Error {}

async function ask(path, body) {
  const request = body === undefined ? {} : { method: 'POST', body: JSON.stringify(body), headers: { 'Content-Type': 'application/json' } };
  const answer = await fetch(path, request);
  const told = await answer.json().catch(() => ({ error: `pvol-view answers ${answer.status} ${answer.statusText}` }));
  if (!answer.ok) throw new Refusal(told.error);
  return told;
}

const pause = (ms) => new Promise((done) => setTimeout(done, ms));

// Requests that change the scene go one by one and in order; the first of those that wait is under way.
let waiting = [], sending = false;
let gesture = Date.now();  // other pages of the same viewer have others

/** Puts what waits and is like the last request into that one: of one value only the last is sent. */
function merged(request) {
  const last = waiting.length > 1 ? waiting[waiting.length - 1] : undefined;
  if (!last) return false;
  if ('frame' in last && 'frame' in request) { last.frame = request.frame; return true; }
  if ('show' in last && 'show' in request) { Object.assign(last.show, request.show); return true; }
  const sets = (r) => r.edits?.every((c) => 'key' in c);
  if (!sets(last) || !sets(request) || last.gesture !== request.gesture) return false;
  const other = (c) => !request.edits.some((e) => e.section === c.section && e.key === c.key);
  last.edits = [...last.edits.filter(other), ...request.edits];
  return true;
}

async function change(request) {
  if (!merged(request)) waiting.push(request);
  if (sending) return;
  sending = true;
  while (waiting.length > 0) {
    try {
      const told = await ask('scene', waiting[0]);
      waiting.shift();
      show(told);
      $('error').textContent = '';
    } catch (error) {
      if (!(error instanceof Refusal)) { await pause(1000); continue; }
      waiting.shift();
      $('error').textContent = error.message;
      await ask('scene').then(show, () => {});
    }
  }
  sending = false;
}

/** Edits as the server takes them; those of one gesture are undone together. */
function edit(changes, ongoing) {
  if (!ongoing) ++gesture;
  lay(changes, scene);
  change({ edits: changes, gesture });
}

// --- what the scene has -------------------------------------------------------------------------

const values = (id) => Object.fromEntries(scene.sections.find((s) => s.id === id).keys.map((k) => [k.key, k.value]));

/** Edits that the server has not answered yet, over what it told. */
function lay(changes, told) {
  for (const c of changes) {
    const key = told.sections.find((s) => s.id === c.section)?.keys.find((k) => k.key === c.key);
    if (key) key.value = c.value;
  }
}

const camera = () => ({ ...values('camera'), aspect: values('render').size[0] / values('render').size[1] });

/** The rectangle of the picture that is rendered: its size in pixels. */
function shownSize() {
  const { size, crop } = values('render');
  return Array.isArray(crop) && crop[2] > 0 ? [crop[2], crop[3]] : size;
}

function editSection(id, changed, ongoing) {
  edit(Object.entries(changed).map(([key, value]) => ({ section: id, key, value })), ongoing);
}

/** Moves the first sun, or that of a clear sky, by a drag in radians. */
function dragSun(across, up) {
  const sun = scene.sections.find((s) => s.id.startsWith('sun'));
  if (sun) return editSection(sun.id, { direction: moveSun(values(sun.id).direction, camera(), across, up) }, true);
  const sky = values('environment');
  if (!('elevation' in sky) || sky.date) {
    $('help').textContent = sky.date ? 'The sun of this sky follows its date.' : 'There is no sun to move.';
    return undefined;
  }
  // Of a clear sky, whose azimuth goes with the clock; it stands there where nothing is set.
  const degrees = 180 / Math.PI, usual = { elevation: 37, azimuth: 245 };
  const elevation = (sky.elevation ?? usual.elevation) + up * degrees;
  const azimuth = (((sky.azimuth ?? usual.azimuth) + across * degrees + 540) % 360) - 180;
  return editSection('environment', { elevation: Math.max(-90, Math.min(90, elevation)), azimuth }, true);
}

const controls = new Controls($('sections'), $('help'), edit, () => values('camera').up);

function fill(select, names, chosen) {
  if (select.options.length !== names.length) select.replaceChildren(...names.map((n) => new Option(n, n)));
  if (chosen !== undefined) select.value = chosen;
}

function show(told) {
  for (const request of waiting) {
    lay(request.edits ?? [], told);
    Object.assign(told, request.show);
    if ('frame' in request) told.frame = request.frame;
  }
  scene = told;
  controls.show(scene.sections);
  fill($('layer'), scene.layers, scene.layer);
  fill($('tone_map'), scene.tone_maps, $('tone_map').value || scene.tone_maps[0]);
  fill($('kinds'), scene.kinds);
  $('filter').checked = scene.filter;
  $('undo').disabled = !scene.undo;
  $('redo').disabled = !scene.redo;
  $('frames').hidden = scene.frames.length === 0;
  $('frame').max = scene.frames.length - 1;
  if (document.activeElement !== $('frame')) $('frame').value = scene.frames.indexOf(scene.frame);
  $('frame_number').value = scene.frame;
  document.title = `${scene.file} – pvol-view`;
  fit();
}

// --- the picture --------------------------------------------------------------------------------

/** The size of the canvas: as large as there is room, up to twice the picture's, with a pixel for each of the
    screen's. */
function fit() {
  if (!scene) return;
  const [width, height] = shownSize();
  const room = $('stage').getBoundingClientRect();
  const scale = Math.min(room.width / width, room.height / height, 2);
  canvas.style.width = `${Math.floor(width * scale)}px`;
  canvas.style.height = `${Math.floor(height * scale)}px`;
  canvas.width = Math.floor(width * scale * devicePixelRatio);
  canvas.height = Math.floor(height * scale * devicePixelRatio);
  draw();
}

function draw() {
  if (film.width * film.height === 0) return;
  const to = canvas.getContext('2d');
  to.imageSmoothingQuality = 'high';
  to.drawImage(film, 0, 0, canvas.width, canvas.height);
}

let fetching = false, again = false;

async function fetchPicture() {
  if (fetching) { again = true; return; }
  fetching = true;
  try {
    do {
      again = false;
      await loadPicture();
    } while (again);
  } finally {
    fetching = false;
  }
}

async function loadPicture() {
  const number = state.number;
  const query = new URLSearchParams({ layer: $('layer').value || 'colour', exposure: $('exposure').value,
    tone_map: $('tone_map').value, filtered: $('filter').checked });
  const answer = await fetch(`picture?${query}`);
  if (answer.status === 400) $('picture_error').textContent = await answer.text();
  if (answer.status !== 200) return;
  $('picture_error').textContent = '';
  const rgb = new Uint8Array(await answer.arrayBuffer());
  const width = Number(answer.headers.get('X-Width')), height = Number(answer.headers.get('X-Height'));
  const image = new ImageData(width, height);
  for (let i = 0, k = 0; k < rgb.length; i += 4, k += 3) {
    image.data[i] = rgb[k];
    image.data[i + 1] = rgb[k + 1];
    image.data[i + 2] = rgb[k + 2];
    image.data[i + 3] = 255;
  }
  film.width = width;
  film.height = height;
  film.getContext('2d').putImageData(image, 0, 0);
  const scale = answer.headers.get('X-Scale');
  $('scale').hidden = !scale;
  if (scale) $('scale').textContent = `dark ${scale.split(' ')[0]}, bright ${scale.split(' ')[1]}`;
  canvas.dataset.number = number;
  draw();
}

/** The same for a change of how it is shown, which may wait until the viewer can be reached again. */
const showAnew = () => { fetchPicture().catch(() => {}); };

const seconds = (s) => (s < 10 ? `${s.toFixed(1)} s` : s < 90 ? `${Math.round(s)} s` : `${Math.round(s / 60)} min`);

function tellProgress() {
  if (!state.width) { $('progress').textContent = state.error ? '' : 'rendering'; return; }
  const parts = [`${state.width} × ${state.height}`];
  const wanted = state.coarse ? 0 : state.wanted / (state.width * state.height);
  parts.push(`${short(Number(state.per_pixel.toFixed(1)))}${wanted > 0 ? ` of ${short(Number(wanted.toFixed(1)))}` : ''} samples per pixel`);
  if (state.noise !== undefined) parts.push(`noise ${(100 * state.noise).toPrecision(2)} %`);
  if (state.filtered) parts.push(`error after the filter ${(100 * state.filter_error).toPrecision(2)} %`);
  if (state.finished) parts.push(`done in ${seconds(state.seconds)}`);
  else if (wanted > 0 && state.per_pixel > 0) parts.push(`about ${seconds((state.seconds * (wanted - state.per_pixel)) / state.per_pixel)} left`);
  $('progress').textContent = parts.join(' · ');
}

/** Follows the picture as long as the page is there. */
async function follow() {
  for (;;) {
    try {
      const before = state.number;
      state = await ask(`state?after=${before}`);
      $('state_error').textContent = state.error;
      tellProgress();
      if (state.change > scene.change && waiting.length === 0) show(await ask('scene'));  // of another page
      if (state.number !== before) await fetchPicture();
      document.body.dataset.finished = state.finished;
      document.body.dataset.change = state.change;
    } catch {
      $('progress').textContent = 'pvol-view has ended, or cannot be reached; start it again and open its new address';
      state = { ...state, number: 0 };
      await pause(1000);
    }
  }
}

// --- pointer and keys ---------------------------------------------------------------------------

const mode = () => document.querySelector('input[name="mode"]:checked').value;
const place = (event) => {
  const box = canvas.getBoundingClientRect();
  return { across: (event.clientX - box.left) / box.width, down: (event.clientY - box.top) / box.height };
};

let last = null;

function drag(event) {
  const box = canvas.getBoundingClientRect();
  const across = (event.clientX - last.clientX) / box.height, down = (event.clientY - last.clientY) / box.height;
  last = event;
  const how = event.buttons === 4 || event.shiftKey ? 'pan' : mode();
  const share = shownSize()[1] / values('render').size[1];  // of the picture's height
  if (how === 'pan') editSection('camera', pan(camera(), -across * share, down * share), true);
  if (how === 'orbit') editSection('camera', orbit(camera(), -3 * across, 3 * down), true);
  if (how === 'sun') dragSun(3 * across, -3 * down);
}

async function focus(event) {
  const { across, down } = place(event);
  try {
    const depth = (await ask(`pixel?across=${across}&down=${down}`)).layers?.depth ?? Infinity;
    if (depth > 1e9) throw new Error('there is nothing to focus on; click a cloud');
    editSection('camera', { focus_distance: Number(depth.toPrecision(6)) }, false);
    if (typeof camera().f_stop !== 'number') $('help').textContent = 'Everything is sharp until f stop is set, under Camera.';
  } catch (error) {
    $('error').textContent = error.message;
  }
}

canvas.addEventListener('pointerdown', (event) => {
  canvas.focus();
  canvas.setPointerCapture(event.pointerId);
  last = event;
  if (mode() === 'focus' && event.button === 0 && !event.shiftKey) focus(event);
});
canvas.addEventListener('pointermove', (event) => { if (event.buttons && last) drag(event); else tellPixel(event); });
for (const end of ['pointerup', 'pointercancel']) canvas.addEventListener(end, () => { last = null; });

// A drag, and what is done in one control, is a gesture; so are turns of the wheel without a pause.
for (const begin of ['pointerdown', 'focusin']) document.addEventListener(begin, () => { ++gesture; }, true);
let turned = 0;
canvas.addEventListener('wheel', (event) => {
  event.preventDefault();
  if (event.timeStamp - turned > 500) ++gesture;
  turned = event.timeStamp;
  editSection('camera', dolly(camera(), Math.exp(event.deltaY / 1000)), true);
}, { passive: false });

let asked = false;

async function tellPixel(event) {
  if (asked) return;
  asked = true;
  const { across, down } = place(event);
  try {
    const p = await ask(`pixel?across=${across}&down=${down}`);
    const number = (v) => Number(v.toPrecision(3));
    const at = state.coarse ? '' : `(${p.x}, ${p.y}) `;  // pixels of a coarse picture are not those of the scene
    const text = [at + p.radiance.map(number).join(' ')];
    if (p.error) text.push(`± ${p.error.map(number).join(' ')}`);
    text.push(`alpha ${number(p.alpha)}`);
    if (p.layers?.depth < 1e9) text.push(`depth ${number(p.layers.depth)}`);
    $('pixel').textContent = text.join(' · ');
  } catch { /* there is no picture yet, or the pointer has left it */ }
  setTimeout(() => { asked = false; }, 80);
}

canvas.addEventListener('keydown', (event) => {
  const step = 0.05;
  const by = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
  if (by) {
    const moved = event.shiftKey ? pan(camera(), by[0] * step, by[1] * step) : orbit(camera(), by[0] * step, by[1] * step);
    editSection('camera', moved, event.repeat);
  } else if (event.key === '+' || event.key === '-') {
    editSection('camera', dolly(camera(), event.key === '+' ? 0.9 : 1 / 0.9), event.repeat);
  } else {
    return;
  }
  event.preventDefault();
});

document.addEventListener('keydown', (event) => {
  if ($('save_dialog').open) return;
  const control = event.ctrlKey || event.metaKey, key = event.key.toLowerCase();
  const active = document.activeElement;
  const typing = active.tagName === 'TEXTAREA' || (active.tagName === 'INPUT' && active.type === 'text');
  if (control && key === 's') $('save').click();
  else if (control && key === 'z' && !typing) $(event.shiftKey ? 'redo' : 'undo').click();
  else if (!control && !event.altKey && !typing && active.tagName !== 'SELECT' && ['1', '2', '3'].includes(key)) {
    const radio = document.querySelectorAll('input[name="mode"]')[Number(key) - 1];
    radio.click();
  } else return;
  event.preventDefault();
});

// --- the bars -----------------------------------------------------------------------------------

$('modes').addEventListener('change', () => { $('stage').dataset.mode = mode(); });
$('exposure').addEventListener('input', () => { $('stops').value = $('exposure').value; showAnew(); });
$('tone_map').addEventListener('change', showAnew);
$('layer').addEventListener('change', () => change({ show: { layer: $('layer').value } }));
$('filter').addEventListener('change', () => change({ show: { filter: $('filter').checked } }));
$('frame').addEventListener('input', () => change({ frame: scene.frames[Number($('frame').value)] }));
$('undo').addEventListener('click', () => change({ undo: true }));
$('redo').addEventListener('click', () => change({ redo: true }));
$('add').addEventListener('click', () => edit([{ add: $('kinds').value }], false));
$('theme').addEventListener('click', () => {
  const root = document.documentElement;
  const dark = root.dataset.theme ? root.dataset.theme === 'dark' : matchMedia('(prefers-color-scheme: dark)').matches;
  root.dataset.theme = dark ? 'light' : 'dark';
});

$('save').addEventListener('click', () => {
  $('folder').textContent = scene.folder;
  $('file').value = scene.file;
  $('save_error').textContent = '';
  $('replace').checked = false;
  $('save_dialog').showModal();
});
$('do_save').addEventListener('click', async (event) => {
  event.preventDefault();
  if (!$('file').reportValidity()) return;
  try {
    while (waiting.length > 0) await pause(20);  // edits that are under way
    const { path } = await ask('save', { name: $('file').value, replace: $('replace').checked });
    scene.file = $('file').value;
    $('save_dialog').close();
    const sequence = scene.frames.length > 0;
    $('help').textContent = `Saved: pvol-render '${path}' -o ${sequence ? 'picture.####.exr --frames A-B' : 'picture.exr'}`;
  } catch (error) {
    $('save_error').textContent = error.message;
  }
});

new ResizeObserver(fit).observe($('stage'));
show(await ask('scene'));
follow();
