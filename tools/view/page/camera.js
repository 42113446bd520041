// What dragging and keys do to a camera: values of its keys in, values of some of them out.

const add = (a, b) => a.map((v, i) => v + b[i]);
const minus = (a, b) => a.map((v, i) => v - b[i]);
const times = (a, s) => a.map((v) => v * s);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [
  a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const length = (a) => Math.hypot(...a);
const unit = (a) => times(a, 1 / length(a));

/** `v` turned about a unit axis (Rodrigues). */
function turn(v, axis, angle) {
  const c = Math.cos(angle), s = Math.sin(angle);
  return add(add(times(v, c), times(cross(axis, v), s)), times(axis, dot(axis, v) * (1 - c)));
}

/** Right, up and forward of the camera, and how far its target is. */
function frame(camera) {
  const view = minus(camera.target, camera.position);
  const forward = unit(view);
  const right = unit(cross(forward, camera.up));
  return { right, up: cross(right, forward), forward, distance: length(view) };
}

const steepest = (89 * Math.PI) / 180;

/** The pitch to turn by, so that the direction stays this side of straight up or down. */
function limited(direction, up, pitch) {
  const now = Math.asin(Math.max(-1, Math.min(1, dot(unit(direction), unit(up)))));
  return Math.max(-steepest, Math.min(steepest, now + pitch)) - now;
}

/** Around the target; a camera that sees all directions turns where it is. Angles in radians. */
export function orbit(camera, yaw, pitch) {
  const { right } = frame(camera);
  const up = unit(camera.up);
  if (camera.projection === 'latlong') {
    const view = minus(camera.target, camera.position);
    const turned = turn(turn(view, right, limited(view, up, -pitch)), up, yaw);
    return { target: add(camera.position, turned) };
  }
  const arm = minus(camera.position, camera.target);
  const turned = turn(turn(arm, right, -limited(arm, up, pitch)), up, yaw);
  return { position: add(camera.target, turned) };
}

/** The height of what is seen at a distance of 1; of an orthographic camera at any. */
function heightSeen(camera) {
  const isWide = camera.sensor_fit === 'horizontal' || (camera.sensor_fit === 'auto' && camera.aspect > 1);
  const share = isWide ? 1 / camera.aspect : 1;  // of the side that sensor and ortho_scale are told of
  if (camera.projection === 'orthographic') return camera.ortho_scale * share;
  if (typeof camera.focal_length === 'number') return (camera.sensor / camera.focal_length) * share;
  return 2 * Math.tan((camera.fov * Math.PI) / 360);
}

/** Sideways and up, in shares of the picture's height. */
export function pan(camera, across, up) {
  const f = frame(camera);
  const height = heightSeen(camera) * (camera.projection === 'orthographic' ? 1 : f.distance);
  const by = add(times(f.right, across * height), times(f.up, up * height));
  return { position: add(camera.position, by), target: add(camera.target, by) };
}

/** Nearer by a factor below 1. */
export function dolly(camera, factor) {
  if (camera.projection === 'orthographic') return { ortho_scale: camera.ortho_scale * factor };
  const arm = minus(camera.position, camera.target);
  return { position: add(camera.target, times(arm, factor)) };
}

/** A direction by its angles about `up`: azimuth from the camera's right, against the clock. */
export function toAngles(direction, up) {
  const { side, front, top } = axes(up);
  const d = unit(direction);
  return { azimuth: Math.atan2(dot(d, front), dot(d, side)), elevation: Math.asin(Math.max(-1, Math.min(1, dot(d, top)))) };
}

export function fromAngles({ azimuth, elevation }, up) {
  const { side, front, top } = axes(up);
  const flat = Math.cos(elevation);
  return add(add(times(side, flat * Math.cos(azimuth)), times(front, flat * Math.sin(azimuth))),
    times(top, Math.sin(elevation)));
}

/** Axes about `up`: x across and, of the other two, what is away from the usual front. */
function axes(up) {
  const top = unit(up);
  const side = unit(cross(top, Math.abs(top[0]) < 0.9 ? cross([1, 0, 0], top) : cross([0, 1, 0], top)));
  return { side, front: cross(top, side), top };
}

/** A sun's direction moved by a drag, in radians, as the camera sees it. */
export function moveSun(direction, camera, across, up) {
  const angles = toAngles(direction, camera.up);
  const elevation = Math.max(-steepest, Math.min(steepest, angles.elevation + up));
  return fromAngles({ azimuth: angles.azimuth - across, elevation }, camera.up);
}
