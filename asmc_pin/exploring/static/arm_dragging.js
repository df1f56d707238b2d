// Dragging a link: the joint above it moves so that what was taken hold of stays under the pointer.
"use strict";
const AsmcDragging = (() => {
  const { THREE } = MeshCat;

  class ArmDragging {
    // `where()` gives the joint values, `move(joint, value)` sets one.
    constructor(stage, { where, move }) {
      Object.assign(this, { stage, where, move });
      this.caster = new THREE.Raycaster();
      const { host } = stage, canvas = stage.canvas;
      host.addEventListener("pointerdown", (event) => this.take(event), true);
      host.addEventListener("pointermove", (event) => this.pull(event), true);
      for (const end of ["pointerup", "pointercancel"]) host.addEventListener(end, (event) => this.leave(event), true);
      // A finger on the arm moves the arm; beside it, it scrolls the page.
      host.addEventListener("touchstart", (event) => {
        if (event.touches.length === 1 && this.hit(event.touches[0])) event.preventDefault();
      }, { passive: false, capture: true });
      canvas.addEventListener("pointermove", (event) => {
        if (!event.buttons) canvas.style.cursor = this.hit(event) ? "grab" : "";
      });
    }

    screen({ clientX, clientY }) {
      const { left, top, width, height } = this.stage.canvas.getBoundingClientRect();
      return new THREE.Vector2(2 * (clientX - left) / width - 1, 1 - 2 * (clientY - top) / height);
    }

    // The link under a point, the coordinate that moves it, and the point in the link's frame.
    hit(event) {
      const { stage } = this, [arm] = stage.arms;
      this.caster.setFromCamera(this.screen(event), stage.viewer.camera);
      const [first] = this.caster.intersectObjects(arm.meshes, false);
      if (!first) return null;
      for (let node = first.object; node; node = node.parent) {
        const body = arm.motions.indexOf(node);
        if (body < 0) continue;
        const { joint } = arm.arm.bodies[body];
        return joint < 0 ? null : { joint, node, point: node.worldToLocal(first.point.clone()) };
      }
      return null;
    }

    take(event) {
      if (!event.isPrimary || event.button !== 0) return;
      this.held = this.hit(event);
      if (!this.held) return;
      event.stopPropagation();
      this.stage.canvas.style.cursor = "grabbing";
      this.stage.host.setPointerCapture(event.pointerId);
    }

    // Where on the screen the held point is at a value of its joint.
    seen(value) {
      const { node, point, joint } = this.held, [arm] = this.stage.arms, q = Array.from(this.where());
      q[joint] = value;
      arm.set(q);
      node.updateWorldMatrix(true, false);
      return node.localToWorld(point.clone()).project(this.stage.viewer.camera);
    }

    // Gauss and Newton's steps towards the pointer, short ones: near a dead point the way is long.
    pull(event) {
      if (!this.held) return;
      event.stopPropagation();
      const goal = this.screen(event), { joint } = this.held, { aspect } = this.stage.viewer.camera;
      let value = this.where()[joint];
      for (let k = 0; k < 4; k++) {
        const now = this.seen(value), near = this.seen(value + 1e-4);
        const dx = aspect * (near.x - now.x) / 1e-4, dy = (near.y - now.y) / 1e-4;
        const left = dx * aspect * (goal.x - now.x) + dy * (goal.y - now.y);
        value += Math.min(Math.max(left / (dx * dx + dy * dy + 1e-3), -0.2), 0.2);
      }
      this.move(joint, value);
    }

    leave(event) {
      if (!this.held) return;
      event.stopPropagation();
      this.held = null;
      this.stage.canvas.style.cursor = "";
    }
  }

  return { ArmDragging };
})();
