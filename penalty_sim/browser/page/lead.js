// Where the hand is led, and the pull from the grip to there.
import * as THREE from 'three';

const COLOUR = {color: 0xd55e00, depthTest: false, transparent: true};

export class Lead {
  constructor(scene, radius) {
    this.ball = new THREE.Mesh(new THREE.SphereGeometry(radius, 16, 12), new THREE.MeshBasicMaterial(COLOUR));
    this.pull = new THREE.Line(new THREE.BufferGeometry().setFromPoints([new THREE.Vector3(), new THREE.Vector3()]), new THREE.LineBasicMaterial(COLOUR));
    this.pull.frustumCulled = false;
    for (const part of [this.ball, this.pull]) { part.renderOrder = 4; part.visible = false; scene.add(part); }
  }
  show({at, led}, grip) {
    this.ball.visible = this.pull.visible = led;
    this.ball.position.set(...at);
    const ends = this.pull.geometry.attributes.position;
    ends.setXYZ(0, grip.x, grip.y, grip.z).setXYZ(1, ...at);
    ends.needsUpdate = true;
  }
}
