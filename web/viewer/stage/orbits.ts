// The ways of picked vertices, as curves that show through the face.
import { Group, SRGBColorSpace, Color, type Material, type Object3D } from 'three';
import { Line2 } from 'three/addons/lines/Line2.js';
import { LineGeometry } from 'three/addons/lines/LineGeometry.js';
import { LineMaterial } from 'three/addons/lines/LineMaterial.js';
import { activeTargets, type Drive } from '../rig/pose';
import { orbit, vertexAt } from '../rig/surface';
import type { Model } from '../types/model';
import { modelColours } from './colours';
import { Dots } from './dots';

const MOMENTS = 97; // of a curve; every 24th is a tick
const TICKS = 5;

export class Orbits {
  readonly group = new Group();
  private key = '';

  /** Draws the ways of vertices in the models of the numbers `places`, under one drive. */
  show(
    models: readonly Model[],
    places: readonly number[],
    drive: Drive,
    picked: readonly number[],
    dark: boolean,
  ): void {
    const key = JSON.stringify([places, drive, picked, dark]);
    if (key === this.key) return;
    this.clear();
    this.key = key;
    const ring: Colour = dark ? [0.08, 0.08, 0.09] : [1, 1, 1];
    for (const place of places) {
      const model = models[place];
      if (!model) continue;
      const active = activeTargets(model, drive);
      const dots = new Dots();
      const colour = colourOf(place);
      for (const vertex of picked) {
        if (vertex < 0 || 3 * vertex >= model.neutral.length) continue;
        const points = orbit(model, drive, vertex, MOMENTS);
        this.add(points, colour, 2.6, false);
        this.add(
          Float32Array.from([...points.subarray(0, 3), ...points.subarray(-3)]),
          colour,
          1.3,
          true,
          dashOf(points),
        );
        for (let tick = 0; tick < TICKS; tick += 1) {
          const at = (3 * tick * (MOMENTS - 1)) / (TICKS - 1);
          dots.add(points.subarray(at, at + 3), 8, colour, ring);
        }
        dots.add(vertexAt(model, active, vertex), 12, colour, ring);
      }
      for (const object of dots.finish()) this.group.add(object);
    }
  }

  clear(): void {
    this.key = '';
    for (const child of [...this.group.children]) {
      const { geometry, material } = child as Object3D & {
        geometry: { dispose(): void };
        material: Material;
      };
      geometry.dispose();
      material.dispose();
      child.removeFromParent();
    }
  }

  /** Twice: faded through the face, and fully where it is before the face. */
  private add(
    points: Float32Array,
    colour: Colour,
    width: number,
    dashed: boolean,
    dash = 1,
  ): void {
    const geometry = new LineGeometry();
    geometry.setPositions(points);
    for (const through of [true, false]) {
      const material = new LineMaterial({
        linewidth: width,
        transparent: true,
        dashed,
        dashSize: dash,
        gapSize: dash,
      });
      material.color = new Color().setRGB(...colour, SRGBColorSpace);
      material.opacity = (through ? 0.6 : 1) * (dashed ? 0.75 : 1);
      material.depthTest = !through;
      material.depthWrite = false;
      const line = new Line2(geometry, material);
      line.computeLineDistances();
      line.frustumCulled = false;
      line.renderOrder = through ? 40 : 41;
      this.group.add(line);
    }
  }
}

type Colour = readonly [number, number, number];

function colourOf(model: number): Colour {
  const { r, g, b } = new Color()
    .setStyle(modelColours[model % modelColours.length]!)
    .getRGB({ r: 0, g: 0, b: 0 }, SRGBColorSpace);
  return [r, g, b];
}

function dashOf(points: Float32Array): number {
  const last = points.length - 3;
  return (
    Math.hypot(
      points[last]! - points[0]!,
      points[last + 1]! - points[1]!,
      points[last + 2]! - points[2]!,
    ) / 19 || 1
  );
}
