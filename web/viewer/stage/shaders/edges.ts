// Lines on the surface, as ribbons that are as wide on the screen everywhere.
import { VERTEX_FETCH } from './vertices';

export const EDGE_VERTEX = /* glsl */ `
${VERTEX_FETCH}
in uvec2 ends;
in vec3 tint;
uniform mat4 modelViewMatrix;
uniform mat4 projectionMatrix;
uniform sampler2D positions;
uniform vec2 viewport; // pixels
uniform float width; // pixels
uniform float lift; // share of the distance by which lines are nearer than the skin
uniform float fade; // pixels below which a line is the fainter the shorter it is
out float across;
out vec3 colour;
out float there;
vec4 onScreen(uint v) {
  vec4 view = modelViewMatrix * vec4(ofVertex(positions, v).xyz, 1.0);
  return projectionMatrix * vec4(view.xyz * (1.0 - lift), 1.0);
}
void main() {
  vec4 a = onScreen(ends.x);
  vec4 b = onScreen(ends.y);
  vec2 way = (b.xy / b.w - a.xy / a.w) * viewport;
  vec2 along = length(way) > 1e-6 ? normalize(way) : vec2(1.0, 0.0);
  float side = gl_VertexID % 2 == 0 ? -1.0 : 1.0;
  vec4 at = gl_VertexID < 2 ? a : b;
  float reach = 0.5 * width + 0.75;
  vec2 aside = vec2(-along.y, along.x) * side * reach + along * (gl_VertexID < 2 ? -0.4 : 0.4) * width;
  at.xy += 2.0 * aside / viewport * at.w;
  across = side * reach;
  colour = tint;
  there = fade > 0.0 ? clamp(0.5 * length(way) / fade, 0.3, 1.0) : 1.0;
  gl_Position = at;
}
`;

export const EDGE_FRAGMENT = /* glsl */ `
precision highp float;
in float across;
in vec3 colour;
in float there;
uniform float width;
uniform float opacity;
uniform vec3 shade;
out vec4 pixel;
void main() {
  float inside = clamp(0.5 * width + 0.5 - abs(across), 0.0, 1.0);
  pixel = vec4(colour * shade, inside * opacity * there);
}
`;
