// SPDX-License-Identifier: MIT
// Path, map and rig in space, by three.js. The world has z upwards.
import {
  BufferAttribute, BufferGeometry, Color, DynamicDrawUsage, Group, Line, LineBasicMaterial, LineSegments,
  PerspectiveCamera, Points, PointsMaterial, Scene, Vector3, WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';

const CAPACITY = 8192;  // points of a geometry
const GRID_CELLS = 15;  // to each side
const RIG_SIZE = 0.05;  // of the distance to the eye

/** A geometry whose points are set anew for each frame. */
function growingGeometry() {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(new Float32Array(3 * CAPACITY), 3).setUsage(DynamicDrawUsage));
  geometry.setDrawRange(0, 0);
  return geometry;
}

function setPoints(object, count, write) {
  const attribute = object.geometry.attributes.position;
  const most = Math.min(count, CAPACITY);
  write(attribute.array, most);
  attribute.needsUpdate = true;
  object.geometry.setDrawRange(0, most);
  object.frustumCulled = false;
}

/** Corners of a camera's field of view at unit depth. */
function frustumOf(camera) {
  const half = camera.width > 0 ? [camera.width / 2, camera.height / 2] : [camera.cu, camera.cv];
  const [a, b] = [half[0] / camera.fu, half[1] / camera.fv];
  const corners = [[-a, -b, 1], [a, -b, 1], [a, b, 1], [-a, b, 1]].map(([x, y, z]) => new Vector3(x, y, z));
  const lines = [];
  corners.forEach((corner, k) => lines.push(new Vector3(), corner, corner, corners[(k + 1) % 4]));
  return new LineSegments(new BufferGeometry().setFromPoints(lines), new LineBasicMaterial());
}

/** A level grid in pieces of a cell: some drivers drop lines that begin behind the eye. */
function gridOf(cell) {
  const points = [];
  for (let k = -GRID_CELLS; k <= GRID_CELLS; ++k) {
    for (let n = -GRID_CELLS; n < GRID_CELLS; ++n) {
      points.push([k, n, k, n + 1], [n, k, n + 1, k]);
    }
  }
  return new BufferGeometry().setFromPoints(points.flatMap(([a, b, c, d]) =>
    [new Vector3(a * cell, b * cell, 0), new Vector3(c * cell, d * cell, 0)]));
}

function place(object, { p, q: [w, x, y, z] }) {
  object.position.set(...p);
  object.quaternion.set(x, y, z, w);
}

export class SpaceView {
  /** @throws Error without WebGL */
  constructor(parent) {
    this.parent = parent;
    this.renderer = new WebGLRenderer({ antialias: true, alpha: true });
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio));
    parent.append(this.renderer.domElement);
    this.scene = new Scene();
    this.eye = new PerspectiveCamera(50, 1, 0.01, 1e5);
    this.eye.up.set(0, 0, 1);
    this.path = new Line(growingGeometry(), new LineBasicMaterial());
    this.former = new Points(growingGeometry(), new PointsMaterial({ size: 1.5, sizeAttenuation: false }));
    this.map = new Points(growingGeometry(), new PointsMaterial({ size: 4, sizeAttenuation: false }));
    this.body = new Group();
    this.scene.add(this.path, this.former, this.map, this.body);
    this.controls = new OrbitControls(this.eye, this.renderer.domElement);
    this.controls.addEventListener('change', () => this.render());
    this.controls.addEventListener('start', () => { this.touched = true; });
    this.follows = true;
    this.fromAbove = false;
    this.extent = 0;
    new ResizeObserver(() => this.resize()).observe(parent);
  }

  /** The rig of a run. */
  begin(run) {
    this.body.clear();
    this.touched = false;
    this.extent = 0;
    this.rig = new Group();
    place(this.rig, run.T_body_cam0);
    this.cam1 = new Group();
    place(this.cam1, run.T_cam0_cam1);
    this.frusta = run.cameras.map(frustumOf);
    this.cam1.add(this.frusta[1]);
    this.rig.add(this.frusta[0], this.cam1);
    this.body.add(this.rig);
    this.baseline = new Vector3(...run.T_cam0_cam1.p).length();
    this.setTheme();
  }

  setTheme() {
    const style = getComputedStyle(this.parent);
    const color = (name) => new Color(style.getPropertyValue(name).trim());
    this.path.material.color = color('--link');
    this.former.material.color = color('--quiet');
    this.map.material.color = color('--used');
    this.gridColor = color('--quiet');
    for (const frustum of this.frusta ?? []) {
      frustum.material.color = color('--ink');
    }
    this.drawGrid();
    this.render();
  }

  show(frame, path, formerMap) {
    setPoints(this.path, path.size, (array, count) => {
      for (let k = 0; k < count; ++k) {
        array.set(path.values.subarray(4 * k + 1, 4 * k + 4), 3 * k);
      }
    });
    setPoints(this.map, frame.map.p.length / 3, (array, count) => array.set(frame.map.p.subarray(0, 3 * count)));
    const places = [...formerMap.places.values()];
    setPoints(this.former, places.length, (array, count) => {
      for (let k = 0; k < count; ++k) {
        array.set(places[k], 3 * k);
      }
    });
    place(this.body, frame);
    this.fit(path);
    if (this.follows) {
      const step = this.body.position.clone().sub(this.controls.target);
      this.controls.target.add(step);
      this.eye.position.add(step);
    }
    this.controls.update();
    this.render();
  }

  /** Until the reader turns it: the path and what is seen from it fit in. */
  fit(path) {
    const extent = Math.max(this.reach(path), 2 * this.baseline, 0.1);
    if (this.touched || (extent < 1.3 * this.extent && extent > 0.4 * this.extent)) {
      return;
    }
    this.extent = extent;
    this.lookFrom(this.fromAbove ? new Vector3(0, -0.001, 1) : new Vector3(-0.55, -0.75, 0.6));
    this.drawGrid();
  }

  /** Distance to which most of the map and of the path lie from here [m]. */
  reach(path) {
    const here = this.body.position.toArray();
    const far = [];
    const add = (array, at) => far.push(Math.hypot(array[at] - here[0], array[at + 1] - here[1], array[at + 2] - here[2]));
    for (let k = 0; k < path.size; k += 8) {
      add(path.values, 4 * k + 1);
    }
    const ofPath = Math.max(0, ...far.splice(0));
    const count = this.map.geometry.drawRange.count;
    for (let k = 0; k < count; ++k) {
      add(this.map.geometry.attributes.position.array, 3 * k);
    }
    far.sort((a, b) => a - b);
    return Math.max(ofPath, far[Math.floor(0.6 * far.length)] ?? 0);
  }

  lookFrom(direction) {
    this.eye.position.copy(this.controls.target).addScaledVector(direction.normalize(), 2.2 * this.extent);
    this.eye.near = 1e-3 * this.extent;
    this.eye.far = 1e3 * this.extent;
    this.eye.updateProjectionMatrix();
    this.controls.update();
  }

  /** Turns to a view from above, or back. */
  look(fromAbove) {
    this.fromAbove = fromAbove;
    this.touched = false;
    this.lookFrom(fromAbove ? new Vector3(0, -0.001, 1) : new Vector3(-0.55, -0.75, 0.6));
    this.render();
  }

  drawGrid() {
    if (!this.extent || !this.gridColor) {
      return;
    }
    if (this.grid) {
      this.scene.remove(this.grid);
      this.grid.geometry.dispose();
      this.grid.material.dispose();
    }
    const cell = 10 ** Math.floor(Math.log10(this.extent));
    this.grid = new LineSegments(gridOf(cell), new LineBasicMaterial({ color: this.gridColor, transparent: true, opacity: 0.3 }));
    this.grid.position.set(...['x', 'y', 'z'].map((axis) => Math.round(this.body.position[axis] / cell) * cell));
    this.scene.add(this.grid);
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.parent;
    if (width > 0 && height > 0) {
      this.renderer.setSize(width, height);
      this.eye.aspect = width / height;
      this.eye.updateProjectionMatrix();
      this.render();
    }
  }

  render() {
    const size = Math.max(RIG_SIZE * this.eye.position.distanceTo(this.body.position), this.baseline ?? 0);
    for (const frustum of this.frusta ?? []) {
      frustum.scale.setScalar(size);
    }
    if (this.cam1 && this.baseline > 0) {  // apart by their baseline, where one can see it
      this.cam1.position.setLength(Math.max(this.baseline, 0.6 * size));
    }
    this.renderer.render(this.scene, this.eye);
  }
}
