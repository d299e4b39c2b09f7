"use strict";
// What is pressed and what moves: chooser, play, slider, speed, camera, keys.

const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4];

class Viewer {
  constructor(root, data) {
    this.root = root;
    this.part = (name) => root.querySelector(`[data-part=${name}]`);
    this.data = data;
    const style = (name) => getComputedStyle(root).getPropertyValue(name).trim();
    try {
      this.stage = new Stage(this.part("scene"), style);
    } catch (error) {
      this.part("scene").hidden = true;
      this.part("no-webgl").hidden = false;
    }
    this.strip = new Strip(this.part("strip"), style, (seconds) => this.seek(seconds));
    this.speed = 1;
    this.listen();
    this.stage?.resize();
    this.choose(0);
    const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
    if (root.dataset.autoplay !== undefined && this.stage && !still) this.play(true);
  }

  listen() {
    const { root, part } = this;
    part("clip").addEventListener("change", (event) => this.choose(Number(event.target.value)));
    part("play").addEventListener("click", () => this.play(!this.playing));
    part("slider").addEventListener("input", (event) => this.seek(Number(event.target.value)));
    part("speed").addEventListener("change", (event) => { this.speed = Number(event.target.value); });
    part("follow").addEventListener("click", () => this.setFollow(!this.stage?.follow));
    part("reset").addEventListener("click", () => this.resetView());
    document.addEventListener("keydown", (event) => this.key(event));
    this.stage?.controls.addEventListener("change", () => this.invalidate());
    new ResizeObserver(() => this.resize()).observe(root);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
      this.stage?.recolour();
      this.invalidate();
    });
    root.addEventListener("pointerenter", () => { this.hovered = true; });
    root.addEventListener("pointerleave", () => { this.hovered = false; });
  }

  choose(index) {
    this.clip = new Clip(this.data.clips[index], this.data.models);
    this.part("clip").value = String(index);
    this.part("note").textContent = this.clip.note;
    const slider = this.part("slider");
    slider.min = this.clip.begin;
    slider.max = this.clip.end;
    slider.step = this.clip.seconds_per_frame;
    this.stage?.show(this.clip);
    this.strip.show(this.clip);
    this.seek(this.clip.begin);
  }

  play(playing) {
    this.playing = playing && this.clip.nFrames > 1;
    const button = this.part("play");
    button.textContent = this.playing ? "Pause" : "Play";
    button.setAttribute("aria-pressed", String(this.playing));
    if (this.playing && this.seconds >= this.clip.end) this.seek(this.clip.begin);
    this.last = undefined;
    this.invalidate();
  }

  seek(seconds) {
    this.seconds = Math.min(Math.max(seconds, this.clip.begin), this.clip.end);
    this.invalidate();
  }

  setFollow(follow) {
    if (!this.stage) return;
    this.stage.follow = follow;
    const button = this.part("follow");
    button.textContent = follow ? "Following" : "Free view";
    button.setAttribute("aria-pressed", String(follow));
    if (follow) this.resetView();
  }

  resetView() {
    this.stage?.reset();
    this.invalidate();
  }

  key(event) {
    const mine = this.root.contains(document.activeElement) || this.hovered || this.data.clips.length === 1;
    if (!mine || event.ctrlKey || event.metaKey || event.altKey || event.target.tagName === "SELECT") return;
    const step = event.shiftKey ? 1 : this.clip.seconds_per_step;
    const faster = (by) => {
      const next = SPEEDS[Math.min(Math.max(SPEEDS.indexOf(this.speed) + by, 0), SPEEDS.length - 1)];
      this.speed = next;
      this.part("speed").value = String(next);
    };
    const actions = {
      " ": () => this.play(!this.playing),
      ArrowLeft: () => this.seek(this.seconds - step),
      ArrowRight: () => this.seek(this.seconds + step),
      Home: () => this.seek(this.clip.begin),
      End: () => this.seek(this.clip.end),
      "+": () => faster(1),
      "=": () => faster(1),
      "-": () => faster(-1),
      f: () => this.setFollow(!this.stage?.follow),
      r: () => this.resetView(),
    };
    const action = actions[event.key];
    if (!action) return;
    event.preventDefault();
    action();
  }

  resize() {
    this.stage?.resize();
    this.invalidate();
  }

  // One picture at the next chance, and another as long as it plays.
  invalidate() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame((now) => {
      this.waiting = false;
      this.frame(now);
    });
  }

  frame(now) {
    if (this.playing) {
      this.seconds += this.last === undefined ? 0 : (this.speed * (now - this.last)) / 1000;
      this.last = now;
      if (this.seconds >= this.clip.end) {
        this.seconds = this.clip.end;
        this.play(false);
      }
    }
    this.part("slider").value = String(this.seconds);
    this.tell();
    this.stage?.set(this.seconds);
    this.stage?.draw();
    this.strip.draw(this.seconds);
    if (this.playing) this.invalidate();
  }

  // In numbers.
  tell() {
    const { clip, seconds } = this;
    const centre = clip.gravityAt(seconds);
    const start = clip.gravityAt(clip.begin);
    const went = Math.hypot(centre[0] - start[0], centre[1] - start[1]);
    const [x, y, z] = centre.map((value) => value.toFixed(2).replace("-", "\u2212"));
    const step = clip.first_control_step + clip.stepAt(seconds) + 1;
    this.part("time").textContent = `${seconds.toFixed(1)} / ${clip.end.toFixed(1)} s`;
    this.part("where").textContent =
      `control step ${step} \u00b7 centre of gravity x ${x}, y ${y}, z ${z} m \u00b7 ${went.toFixed(2)} m from the start`;
  }
}

for (const root of document.querySelectorAll("[data-viewer]")) {
  const data = JSON.parse(document.getElementById(root.dataset.viewer).textContent);
  root.viewer = new Viewer(root, data);
}
