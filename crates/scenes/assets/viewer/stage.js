"use strict";
// The robot in 3-D: shapes, ground with metres on it, path of the centre of gravity, camera.
// z is up; 1 is a metre.

const GRID = 40; // the grid has so many lines on either side of the robot
const LABELS = 9; // on either side of the robot along each row

class Stage {
  // Throws where there's no WebGL.
  constructor(canvas, style) {
    this.canvas = canvas;
    this.style = style;
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true });
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = THREE.PCFShadowMap;
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(38, 1, 0.1, 300);
    this.camera.up.set(0, 0, 1);
    this.controls = new THREE.OrbitControls(this.camera, canvas);
    this.controls.maxPolarAngle = Math.PI / 2 - 0.03;
    this.controls.minDistance = 1;
    this.controls.maxDistance = 60;
    this.follow = true;
    this.centre = new THREE.Vector3();
    this.robot = new THREE.Group();
    this.scene.add(this.robot);
    this.labels = new Map();
    this.light();
    this.ground();
    this.recolour();
  }

  light() {
    this.sky = new THREE.HemisphereLight(0xffffff, 0xc9c9c9, 1.7);
    this.sun = new THREE.DirectionalLight(0xfffaf2, 2.0);
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.set(2048, 2048);
    this.sun.shadow.radius = 5;
    this.sun.shadow.bias = -0.0005;
    this.sun.shadow.normalBias = 0.02;
    this.scene.add(this.sky, this.sun, this.sun.target);
  }

  ground() {
    const flat = (size, material) => new THREE.Mesh(new THREE.PlaneGeometry(size, size), material);
    this.floorMaterial = new THREE.MeshStandardMaterial({ roughness: 1, polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 4 });
    this.floor = flat(600, this.floorMaterial);
    this.floor.receiveShadow = true;
    // They darken what they lie on, shadows too, or lighten it at night.
    this.thin = new THREE.MeshBasicMaterial({ transparent: true, opacity: 0.16, depthWrite: false });
    this.bold = new THREE.MeshBasicMaterial({ transparent: true, opacity: 0.34, depthWrite: false });
    this.grid = new THREE.Group();
    this.grid.add(lines((at) => at % 5 !== 0, 0.006, 0.001, this.thin), lines((at) => at % 5 === 0, 0.016, 0.002, this.bold));
    this.signs = new THREE.Group();
    this.scene.add(this.floor, this.grid, this.signs);
  }

  // Takes the page's colours, which may be those of night.
  recolour() {
    const colour = (name) => new THREE.Color(this.style(name));
    const background = colour("--stage");
    this.scene.background = background;
    const { near = 14, far = GRID } = this.scene.fog ?? {};
    this.scene.fog = new THREE.Fog(background, near, far);
    this.floorMaterial.color = colour("--floor");
    this.thin.color = this.bold.color = colour("--stage-text");
    this.clearLabels();
    this.pathColours?.forEach(([material, name]) => { material.color = colour(name); });
  }

  clearLabels() {
    this.labels.forEach((label) => label.map.dispose());
    this.labels.clear();
    this.signs.clear();
    this.rowX = this.rowY = undefined;
  }

  // Puts another robot and its path there.
  show(clip) {
    this.clip = clip;
    this.robot.clear();
    this.parts = clip.model.bodies.map((body) => this.part(body));
    this.parts.forEach((part) => this.robot.add(part.group, part.spot));
    const place = new THREE.Vector3();
    clip.gravity(0, this.centre, place);
    const reaches = this.parts.map((part, i) => {
      clip.pose(0, i, place);
      return place.distanceTo(this.centre) + part.reach;
    });
    this.size = Math.max(0.1, ...reaches);
    // From line to line, in m: around small robots all is smaller.
    this.unit = this.size < 1.5 ? 0.2 : 1;
    this.grid.scale.set(this.unit, this.unit, 1);
    this.scene.fog.near = 14 * this.unit;
    this.scene.fog.far = GRID * this.unit;
    this.clearLabels();
    this.parts.forEach(({ spot, breadth }) => {
      spot.scale.setScalar(1.3 * breadth + 0.015 * this.size);
    });
    this.drawPath();
    const reach = this.size * 1.6;
    const shadow = this.sun.shadow.camera;
    Object.assign(shadow, { left: -reach, right: reach, top: reach, bottom: -reach, near: 0.1, far: 12 * reach });
    shadow.updateProjectionMatrix();
    this.reset();
  }

  part(body) {
    const material = new THREE.MeshStandardMaterial({ color: body.colour, roughness: 0.62, metalness: 0.02 });
    const group = new THREE.Group();
    body.shapes.forEach((shape) => group.add(solidOf(shape, material)));
    const glow = this.style(body.penalised ? "--warning" : "--contact");
    const light = new THREE.MeshBasicMaterial({ color: glow, transparent: true, opacity: 0.75, depthWrite: false });
    const spot = new THREE.Mesh(new THREE.CircleGeometry(1, 40), light);
    spot.position.z = 0.006;
    return { group, material, spot, glow: new THREE.Color(glow), colour: new THREE.Color(body.colour), ...measuresOf(body.shapes) };
  }

  // On the ground below the centre of gravity: what is done, and what comes.
  drawPath() {
    this.path?.forEach((mesh) => { this.scene.remove(mesh); mesh.geometry.dispose(); });
    const { clip } = this;
    const corners = [];
    const scratch = new THREE.Vector3();
    const centre = (frame) => {
      const inside = Math.min(Math.max(frame, 0), clip.nFrames - 1);
      return clip.gravity(inside, new THREE.Vector3(), scratch);
    };
    // Across the way over half a second: from frame to frame it shakes.
    const near = Math.max(1, Math.round(0.25 / clip.seconds_per_frame));
    for (let frame = 0; frame < clip.nFrames; frame += 1) {
      const [here, from, to] = [centre(frame), centre(frame - near), centre(frame + near)];
      const across = new THREE.Vector3(from.y - to.y, to.x - from.x, 0).setLength(0.006 * this.size);
      corners.push(here.x + across.x, here.y + across.y, 0, here.x - across.x, here.y - across.y, 0);
    }
    const index = [];
    for (let i = 0; i + 3 < corners.length / 3; i += 2) index.push(i, i + 1, i + 2, i + 2, i + 1, i + 3);
    const ribbon = (name, height) => {
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(corners), 3));
      geometry.setIndex(index);
      const material = new THREE.MeshBasicMaterial({ color: this.style(name), side: 2 });
      const mesh = new THREE.Mesh(geometry, material);
      mesh.position.z = height;
      mesh.frustumCulled = false;
      this.scene.add(mesh);
      return mesh;
    };
    const dot = new THREE.Mesh(new THREE.CircleGeometry(0.022 * this.size, 32), new THREE.MeshBasicMaterial({ color: this.style("--path") }));
    dot.position.z = 0.008;
    this.scene.add(dot);
    this.path = [ribbon("--path-to-come", 0.003), ribbon("--path", 0.004), dot];
    this.pathColours = [[this.path[0].material, "--path-to-come"], [this.path[1].material, "--path"], [dot.material, "--path"]];
  }

  // Puts all where it is at a moment, in s.
  set(seconds) {
    const { clip } = this;
    const { before, after, share } = clip.around(seconds);
    const step = clip.stepAt(seconds);
    const [p, q] = [new THREE.Vector3(), new THREE.Quaternion()];
    this.parts.forEach((part, i) => {
      clip.pose(before, i, part.group.position, part.group.quaternion);
      clip.pose(after, i, p, q);
      part.group.position.lerp(p, share);
      part.group.quaternion.slerp(q, share);
      const touches = clip.touches(step, i);
      part.material.color.copy(touches ? part.glow : part.colour);
      part.material.emissive.copy(part.glow).multiplyScalar(touches ? 0.35 : 0);
      part.spot.visible = touches;
      if (touches) this.underfoot(part);
    });
    const last = this.centre.clone();
    this.centre.set(...clip.gravityAt(seconds));
    this.path[1].geometry.setDrawRange(0, 6 * (before + (share > 0.5 ? 1 : 0)));
    this.path[2].position.set(this.centre.x, this.centre.y, 0.008);
    if (this.follow) {
      const moved = this.centre.clone().sub(last).setZ(0);
      this.camera.position.add(moved);
      this.controls.target.add(moved);
    }
    this.surround();
  }

  // Below the lowest end of what touches.
  underfoot({ group, spot, ends }) {
    const points = ends.map((end) => end.clone().applyQuaternion(group.quaternion).add(group.position));
    const lowest = points.reduce((a, b) => (b.z < a.z ? b : a));
    spot.position.set(lowest.x, lowest.y, 0.006);
  }

  // Light, grid and labels go with the robot.
  surround() {
    const { x, y } = this.centre;
    const sun = new THREE.Vector3(-1.6, -1.1, 3.2).setLength(5 * this.size);
    this.sun.target.position.set(x, y, 0);
    this.sun.position.set(x, y, 0).add(sun);
    this.floor.position.set(x, y, 0);
    const five = 5 * this.unit;
    this.grid.position.set(five * Math.round(x / five), five * Math.round(y / five), 0);
    this.sign();
  }

  // Metres along two rows, beside the robot and behind it, turned to whoever looks.
  sign() {
    const { unit } = this;
    const [x, y] = [this.centre.x / unit, this.centre.y / unit];
    const away = Math.ceil(this.size / unit) + 0.5;
    const keep = (row, wanted) => (row !== undefined && Math.abs(row - wanted) < 1.5 ? row : Math.round(wanted));
    const view = this.camera.position.clone().sub(this.controls.target);
    const quarter = Math.round(Math.atan2(view.x, -view.y) / (Math.PI / 2));
    this.rowX = keep(this.rowX, x + away * (view.x < 0 ? -1 : 1));
    this.rowY = keep(this.rowY, y + away * (view.y < 0 ? -1 : 1));
    const metres = (line) => (line * unit).toFixed(unit < 1 ? 1 : 0);
    const wanted = new Map();
    for (let i = -LABELS; i <= LABELS; i += 1) {
      const [alongX, alongY] = [Math.round(x) + i, Math.round(y) + i];
      // Where the rows cross, neither is written.
      if (Math.abs(alongX - this.rowX) > 1) wanted.set(`x${alongX}`, [alongX, this.rowY, `x ${metres(alongX)} m`]);
      if (Math.abs(alongY - this.rowY) > 1) wanted.set(`y${alongY}`, [this.rowX, alongY, `y ${metres(alongY)} m`]);
    }
    for (const [key, label] of this.labels) {
      if (!wanted.has(key)) {
        this.signs.remove(label);
        label.map.dispose();
        this.labels.delete(key);
      }
    }
    for (const [key, [atX, atY, text]] of wanted) {
      if (!this.labels.has(key)) this.labels.set(key, this.label(text));
      const label = this.labels.get(key);
      label.position.set(atX * unit, atY * unit, 0.01 * unit);
      label.scale.setScalar(unit);
      label.rotation.z = (quarter * Math.PI) / 2;
    }
  }

  label(text) {
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [256, 80];
    const pen = canvas.getContext("2d");
    pen.font = "600 52px system-ui, sans-serif";
    pen.textAlign = "center";
    pen.textBaseline = "middle";
    pen.fillStyle = this.style("--stage-text");
    pen.fillText(text.replace("-", "\u2212"), 128, 42);
    const map = new THREE.CanvasTexture(canvas);
    map.anisotropy = 8;
    map.colorSpace = THREE.SRGBColorSpace;
    const material = new THREE.MeshBasicMaterial({ map, transparent: true, depthWrite: false });
    const label = new THREE.Mesh(new THREE.PlaneGeometry(0.8, 0.25), material);
    label.map = map;
    this.signs.add(label);
    return label;
  }

  // Back to the view from ahead and aside, near enough to see all of the robot.
  reset() {
    const distance = this.size * Math.max(2.55, 3 / this.camera.aspect);
    this.controls.target.set(this.centre.x, this.centre.y, 0.5 * this.centre.z);
    const direction = new THREE.Vector3(0.8, 0.8, 0.62).setLength(distance);
    this.camera.position.copy(this.controls.target).add(direction);
    this.controls.update();
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (width === 0 || height === 0) return;
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
  }

  draw() {
    this.controls.update();
    this.sign();
    this.renderer.render(this.scene, this.camera);
  }
}

// Lines at some of the metres, along x and along y, half as wide as that.
function lines(chosen, half, height, material) {
  const [corners, index] = [[], []];
  const bar = (x0, y0, x1, y1) => {
    const n = corners.length / 3;
    corners.push(x0, y0, height, x1, y0, height, x1, y1, height, x0, y1, height);
    index.push(n, n + 1, n + 2, n, n + 2, n + 3);
  };
  for (let at = -GRID; at <= GRID; at += 1) {
    if (!chosen(at)) continue;
    bar(at - half, -GRID, at + half, GRID);
    bar(-GRID, at - half, GRID, at + half);
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(corners), 3));
  geometry.setIndex(index);
  return new THREE.Mesh(geometry, material);
}

// A shape where it lies in its body.
function solidOf(shape, material) {
  const mesh = new THREE.Mesh(geometryOf(shape), material);
  mesh.castShadow = mesh.receiveShadow = true;
  const { from, to } = shape;
  if (from) {
    // three.js' capsules and cylinders lie along y.
    const [a, b] = [new THREE.Vector3(...from), new THREE.Vector3(...to)];
    mesh.position.addVectors(a, b).multiplyScalar(0.5);
    mesh.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), b.sub(a).normalize());
  }
  if (shape.radii) mesh.scale.set(...shape.radii);
  const place = new THREE.Group();
  place.position.set(...shape.position);
  place.quaternion.set(...shape.rotation);
  place.add(mesh);
  return place;
}

// Of shapes together: how far they reach from the body's origin, half of how broad the broadest is,
// and the ends of which one touches the ground. What has no shape is a point.
function measuresOf(shapes) {
  const measures = { reach: 0, breadth: 0, ends: [] };
  for (const shape of shapes) {
    const turn = new THREE.Quaternion(...shape.rotation);
    const place = (point) => new THREE.Vector3(...point).applyQuaternion(turn).add(new THREE.Vector3(...shape.position));
    const half = shape.half ?? shape.radii;
    const points = pointsOf(shape);
    const radius = shape.radius ?? (half ? Math.hypot(...half) : 0);
    const far = points.map((point) => place(point).length() + radius);
    measures.reach = Math.max(measures.reach, ...far);
    measures.breadth = Math.max(measures.breadth, breadthOf(shape));
    measures.ends.push(...points.map(place));
  }
  if (measures.ends.length === 0) measures.ends.push(new THREE.Vector3());
  return measures;
}

function breadthOf(shape) {
  if (shape.radius) return shape.radius;
  const sizes = shape.corners ? pointsOf(shape) : [shape.half ?? shape.radii];
  return Math.max(...sizes.flatMap(([x, y]) => [Math.abs(x), Math.abs(y)]));
}

// Points around which a shape lies: the ends of a rod, the corners of a hull, the middle of others.
function pointsOf(shape) {
  if (shape.from) return [shape.from, shape.to];
  if (!shape.corners) return [[0, 0, 0]];
  const corners = [];
  for (let i = 0; i < shape.corners.length; i += 3) corners.push(shape.corners.slice(i, i + 3));
  return corners;
}

function geometryOf(shape) {
  const length = shape.from ? Math.hypot(...shape.from.map((value, i) => value - shape.to[i])) : 0;
  switch (shape.kind) {
    case "box": return new THREE.BoxGeometry(...shape.half.map((half) => 2 * half));
    case "sphere": return new THREE.SphereGeometry(shape.radius, 40, 24);
    case "ellipsoid": return new THREE.SphereGeometry(1, 40, 24);
    case "capsule": return new THREE.CapsuleGeometry(shape.radius, length, 12, 32);
    case "hull": {
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(shape.corners), 3));
      geometry.computeVertexNormals();
      return geometry;
    }
    default: return new THREE.CylinderGeometry(shape.radius, shape.radius, length, 40);
  }
}
