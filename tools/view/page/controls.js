// The controls of a scene's values, made of what the server tells of each key.
import { fromAngles, toAngles } from './camera.js';

const element = (name, attributes = {}, ...children) => {
  const made = Object.assign(document.createElement(name), attributes);
  made.append(...children);
  return made;
};
const svg = (name, attributes = {}) => {
  const made = document.createElementNS('http://www.w3.org/2000/svg', name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  return made;
};

/** A whole number as it is, others in at most six digits. */
export const short = (v) => (typeof v === 'number' && !Number.isSafeInteger(v) ? String(Number(v.toPrecision(6))) : String(v));
const join = (v) => (Array.isArray(v) ? v.map(short).join(', ') : short(v));
/** Three equal channels as one number. */
const joinGrey = (v) => (Array.isArray(v) && v.every((c) => c === v[0]) ? short(v[0]) : join(v));

const split = (text) => text.split(/[\s,]+/).filter((part) => part !== '');
/** Numbers of a text, one or a list, those that are shown as before with all their digits; a text that is none
    of these stays one, for the server, as do numbers that scripts cannot tell apart. */
function parse(text, before) {
  const parts = split(text);
  const numbers = parts.map(Number);
  if (parts.length === 0 || numbers.some(Number.isNaN)) return text.trim().replace(/\s*,\s*/g, ',');
  if (parts.some((part, i) => Number.isInteger(numbers[i]) && !Number.isSafeInteger(numbers[i]))) return text.trim();
  const known = before === null || before === undefined ? [] : [before].flat();
  const kept = numbers.map((v, i) => (known.length === parts.length && parts[i] === short(known[i]) ? known[i] : v));
  return kept.length === 1 ? kept[0] : kept;
}

const toLinear = (byte) => {
  const v = byte / 255;
  return v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;
};
const toByte = (v) => Math.round(255 * (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055));

/** A colour as its largest channel and the swatch of its shares. */
function splitColour(value) {
  const rgb = Array.isArray(value) ? value : [value, value, value];
  const strength = Math.max(...rgb);
  const shares = rgb.map((v) => (strength > 0 ? v / strength : 1));
  const hex = strength > 0 ? '#' + shares.map((v) => toByte(v).toString(16).padStart(2, '0')).join('') : '#000000';
  return { strength, shares, hex };
}
const sharesOf = (hex) => {
  const shares = [1, 3, 5].map((i) => toLinear(parseInt(hex.slice(i, i + 2), 16)));
  const most = Math.max(...shares);
  return shares.map((v) => (most > 0 ? v / most : 0));
};
/** Grey as one number. */
const joinColour = (strength, shares) => {
  const rgb = shares.map((v) => Number((v * strength).toPrecision(6)));
  return rgb.every((v) => v === rgb[0]) ? rgb[0] : rgb;
};

const kSteps = 1000;
const toSlider = (s, v) => (s.log ? Math.log(Math.max(v, s.lo) / s.lo) / Math.log(s.hi / s.lo) : (v - s.lo) / (s.hi - s.lo)) * kSteps;
const fromSlider = (s, at) => {
  const share = at / kSteps;
  return Number((s.log ? s.lo * (s.hi / s.lo) ** share : s.lo + share * (s.hi - s.lo)).toPrecision(4));
};

/** A dome from above: its middle is straight up, the inner circle the horizon. */
function dial(get, set, up) {
  const radius = 32;
  const root = svg('svg', { width: 70, height: 70, viewBox: '-35 -35 70 70', tabindex: 0, role: 'slider',
    'aria-label': 'Direction: arrow keys turn and raise it' });
  const mark = svg('circle', { r: 4, class: 'mark' });
  root.append(svg('circle', { r: radius }), svg('circle', { r: radius / 2 }), mark);
  const show = () => {
    const { azimuth, elevation } = toAngles(get(), up());
    const r = radius * (0.5 - elevation / Math.PI);
    mark.setAttribute('cx', r * Math.cos(azimuth));
    mark.setAttribute('cy', -r * Math.sin(azimuth));
    root.setAttribute('aria-valuetext', `${Math.round((azimuth * 180) / Math.PI)}° about up, ${Math.round((elevation * 180) / Math.PI)}° above the horizon`);
  };
  const move = (event) => {
    const box = root.getBoundingClientRect();
    const x = event.clientX - box.left - box.width / 2, y = event.clientY - box.top - box.height / 2;
    const r = Math.min(Math.hypot(x, y), radius * 0.99);
    set(fromAngles({ azimuth: Math.atan2(-y, x), elevation: Math.PI * (0.5 - r / radius) }, up()), true);
  };
  root.addEventListener('pointerdown', (event) => { root.setPointerCapture(event.pointerId); move(event); });
  root.addEventListener('pointermove', (event) => { if (root.hasPointerCapture(event.pointerId)) move(event); });
  root.addEventListener('keydown', (event) => {
    const step = Math.PI / 60;
    const by = { ArrowLeft: [step, 0], ArrowRight: [-step, 0], ArrowUp: [0, step], ArrowDown: [0, -step] }[event.key];
    if (!by) return;
    event.preventDefault();
    const a = toAngles(get(), up());
    const elevation = Math.max(-1.55, Math.min(1.55, a.elevation + by[1]));
    set(fromAngles({ azimuth: a.azimuth + by[0], elevation }, up()), false);
  });
  return { root, show };
}

/** Points of a function, to be dragged up and down. */
function plot(get, set) {
  const width = 190, height = 60;
  const root = svg('svg', { width, height, viewBox: `0 0 ${width} ${height}`, 'aria-hidden': 'true' });
  const line = svg('polyline');
  root.append(line);
  let most = 1, dragged = -1;
  const show = () => {
    const rows = get();
    const valid = Array.isArray(rows) && rows.length > 1 && rows.every((r) => Array.isArray(r) && r.length === 2);
    root.style.display = valid ? '' : 'none';
    if (!valid) return;
    if (dragged < 0) most = Math.max(...rows.map((r) => r[1]), 1e-9) * 1.1;
    const lo = rows[0][0], hi = rows[rows.length - 1][0];
    const at = rows.map(([x, y]) => [4 + ((x - lo) / (hi - lo)) * (width - 8), height - 4 - (y / most) * (height - 8)]);
    line.setAttribute('points', at.map((p) => p.join()).join(' '));
    root.querySelectorAll('.mark').forEach((mark) => mark.remove());
    at.forEach(([x, y], i) => root.append(svg('circle', { r: 4, cx: x, cy: y, class: 'mark', 'data-i': i })));
  };
  root.addEventListener('pointerdown', (event) => {
    dragged = Number(event.target.dataset.i ?? -1);
    if (dragged >= 0) root.setPointerCapture(event.pointerId);
  });
  root.addEventListener('pointermove', (event) => {
    if (dragged < 0 || !event.buttons) return;
    const y = event.clientY - root.getBoundingClientRect().top;
    const rows = get().map((r) => [...r]);
    rows[dragged][1] = Number((Math.max(0, (height - 4 - y) / (height - 8)) * most).toPrecision(4));
    set(rows, true);
  });
  for (const end of ['pointerup', 'pointercancel']) root.addEventListener(end, () => { dragged = -1; });
  return { root, show };
}

/** One control: its element, and `show(key)` for what the server tells of it. */
function control(key, id, set, up) {
  let now = key;
  const box = element('span', { className: 'value' });
  const parts = [];
  const change = (value, ongoing = false) => { now = { ...now, value }; set(value, ongoing); show(now); };
  const put = (node, shown) => { box.append(node); parts.push({ node, shown }); };
  const text = (className) => {
    const input = element('input', { id, className, type: 'text', autocomplete: 'off' });
    input.addEventListener('change', () => {
      if (now.shape === 'text') change(input.value);
      else if (input.value.trim() !== '') change(parse(input.value, now.value));
      else if (now.nothing) change(now.nothing);
      else shown();  // an empty field is no value
    });
    const shown = () => {
      input.value = now.value === null ? '' : now.shape === 'colour' ? joinGrey(now.value) : join(now.value);
      input.placeholder = now.nothing ?? '';
    };
    input.addEventListener('blur', shown);  // what was refused goes
    put(input, shown);
  };
  const slider = (get, change_to) => {
    if (!now.slider) return;
    const input = element('input', { type: 'range', min: 0, max: kSteps, step: 1 });
    input.setAttribute('aria-label', `${now.key}, slider`);
    input.addEventListener('input', () => change_to(fromSlider(ends, Number(input.value)), true));
    let ends = now.slider;
    put(input, () => {
      if (document.activeElement !== input) ends = now.slider;
      const v = get();
      if (typeof v === 'number') input.value = toSlider(ends, v);
    });
  };
  const whole = (v) => (now.shape === 'whole' ? Math.round(v) : v);

  if (now.shape === 'flag') {
    const input = element('input', { id, type: 'checkbox' });
    input.addEventListener('change', () => change(input.checked));
    put(input, () => { input.checked = now.value === true; });
  } else if (now.shape === 'word') {
    const input = element('select', { id });
    input.append(...now.words.map((w) => element('option', {}, w)));
    input.addEventListener('change', () => change(input.value));
    put(input, () => { input.value = now.value ?? now.nothing; });
  } else if (now.shape === 'colour') {
    const swatch = element('input', { type: 'color' });
    swatch.setAttribute('aria-label', `${now.key}, colour`);
    swatch.addEventListener('input', () => change(joinColour(splitColour(now.value).strength || 1, sharesOf(swatch.value)), true));
    put(swatch, () => { swatch.value = splitColour(now.value).hex; });
    slider(() => splitColour(now.value).strength, (v, ongoing) => change(joinColour(v, splitColour(now.value).shares), ongoing));
    text('number');
  } else if (now.shape === 'rows') {
    const columns = { className: 'wide', id, rows: 3, spellcheck: false };
    const input = element('textarea', columns);
    input.addEventListener('change', () => {
      const rows = input.value.split('\n').map((line, i) => parse(line, now.value?.[i])).filter((r) => r !== '');
      change(rows);
    });
    const curve = plot(() => now.value, change);
    const shown = () => { input.value = (now.value ?? []).map(join).join('\n'); };
    const stack = element('span', { className: 'wide' }, curve.root, input);
    put(stack, () => { if (document.activeElement !== input) shown(); curve.show(); });
  } else if (now.shape === 'direction') {
    const dome = dial(() => now.value, change, up);
    put(dome.root, dome.show);
    text('wide');
  } else {
    slider(() => now.value, (v, ongoing) => change(whole(v), ongoing));
    text(now.slider ? 'number' : 'wide');
  }
  if (now.unit) box.append(element('span', { className: 'unit' }, now.unit));
  const show = (told) => {
    now = told;
    // What somebody types into stays as it is.
    for (const { node, shown } of parts) if (document.activeElement !== node || node.type !== 'text') shown();
  };
  show(key);
  return { root: box, show };
}

/** All sections of a scene. `edit(changes, ongoing)` takes changes as the server does. */
export class Controls {
  constructor(root, help, edit, up) {
    Object.assign(this, { root, help, edit, up, shape: '', controls: new Map() });
  }

  /** Shows the sections; makes new controls only where their keys are others. */
  show(sections) {
    const shape = JSON.stringify(sections.map((s) => [s.id, s.title, s.keys.map((k) => [k.key, k.shape, !!k.slider])]));
    if (shape !== this.shape) this.make(sections);
    this.shape = shape;
    for (const section of sections) {
      for (const key of section.keys) this.controls.get(`${section.id}.${key.key}`).show(key);
    }
  }

  make(sections) {
    const open = new Set([...this.root.querySelectorAll('details[open]')].map((d) => d.dataset.id));
    const focused = document.activeElement?.id;
    this.controls.clear();
    this.root.replaceChildren(...sections.map((s, i) => this.section(s, this.shape ? open.has(s.id) : i === 0 || s.id.startsWith('sun'))));
    if (focused) document.getElementById(focused)?.focus();
  }

  section(section, open) {
    const summary = element('summary', {}, section.title);
    if (section.removable) {
      const button = element('button', { type: 'button', title: `Remove ${section.title}` }, '×');
      button.setAttribute('aria-label', button.title);
      button.addEventListener('click', (event) => { event.preventDefault(); this.edit([{ remove: section.id }], false); });
      summary.append(button);
    }
    const details = element('details', { open }, summary, ...section.keys.map((key) => this.row(section, key)));
    details.dataset.id = section.id;
    return details;
  }

  row(section, key) {
    const name = `${section.id}.${key.key}`;
    const set = (value, ongoing) => {
      const changes = [{ section: section.id, key: key.key, value }];
      if (section.id === 'environment' && key.key === 'type' && value === 'image') {  // is none without a file
        const file = prompt('Picture of the sky by longitude and latitude: name of an .exr or .hdr file');
        if (!file) return this.controls.get(name).show(key);
        changes.push({ section: section.id, key: 'file', value: file });
      }
      this.edit(changes, ongoing);
    };
    const made = control(key, `key_${name}`, set, this.up);
    this.controls.set(name, made);
    const label = element('label', { htmlFor: `key_${name}`, className: key.biased ? 'biased' : '' }, key.key.replaceAll('_', ' '));
    const row = element('div', { className: 'row' }, label, made.root);
    row.title = key.help;
    const tell = () => { this.help.textContent = `${key.help}. Takes ${key.expected}.`; };
    row.addEventListener('focusin', tell);
    row.addEventListener('pointerenter', tell);
    return row;
  }
}
