"use strict";
// A robot's motion as the page's JSON has it: numbers unpacked, frames interpolated.

const POSE = 7; // x y z, then the orientation as a quaternion x y z w

function bytesOf(base64) {
  return Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0)).buffer;
}

class Clip {
  constructor(packed, models) {
    Object.assign(this, packed);
    this.model = models[packed.model];
    this.nBodies = this.model.bodies.length;
    this.poses = new Int16Array(bytesOf(packed.poses));
    this.contacts = new Uint8Array(bytesOf(packed.contacts));
    this.terms = packed.terms.map((term) => ({ ...term, values: new Float32Array(bytesOf(term.values)) }));
    this.nFrames = this.poses.length / (POSE * this.nBodies);
    this.nSteps = this.contacts.length / this.nBodies;
    this.begin = packed.first_frame_s;
    this.end = this.begin + (this.nFrames - 1) * packed.seconds_per_frame;
    this.mass = this.model.bodies.reduce((sum, body) => sum + body.mass_kg, 0);
  }

  // Position in m and orientation of a body at a frame.
  pose(frame, body, position, rotation) {
    const at = (frame * this.nBodies + body) * POSE;
    const [p, c, s] = [this.poses, this.centre_m, this.step_m];
    position.set(c[0] + s[0] * p[at], c[1] + s[1] * p[at + 1], c[2] + s[2] * p[at + 2]);
    rotation?.set(p[at + 3], p[at + 4], p[at + 5], p[at + 6]).normalize();
  }

  // The frames beside a moment, in s, and how far it is from the one to the other.
  around(seconds) {
    const place = Math.min(Math.max((seconds - this.begin) / this.seconds_per_frame, 0), this.nFrames - 1);
    const before = Math.min(Math.floor(place), Math.max(this.nFrames - 2, 0));
    return { before, after: Math.min(before + 1, this.nFrames - 1), share: place - before };
  }

  // The control step that a moment belongs to, from 0. A step's last frame is at its end.
  stepAt(seconds) {
    const step = Math.ceil(seconds / this.seconds_per_step - 1e-6) - 1;
    return Math.min(Math.max(step, 0), this.nSteps - 1);
  }

  touches(step, body) {
    return this.contacts[step * this.nBodies + body] !== 0;
  }

  // Centre of gravity at a frame, in m.
  gravity(frame, centre, scratch) {
    centre.x = centre.y = centre.z = 0;
    this.model.bodies.forEach((body, i) => {
      this.pose(frame, i, scratch);
      for (const axis of "xyz") centre[axis] += (scratch[axis] * body.mass_kg) / this.mass;
    });
    return centre;
  }

  // The same at any moment: on the line between frames.
  gravityAt(seconds) {
    const plain = () => ({ x: 0, y: 0, z: 0, set(x, y, z) { Object.assign(this, { x, y, z }); } });
    const { before, after, share } = this.around(seconds);
    const [a, b] = [before, after].map((frame) => this.gravity(frame, plain(), plain()));
    return ["x", "y", "z"].map((axis) => a[axis] + share * (b[axis] - a[axis]));
  }
}
