// What is behind a face.

export const BACKDROP_FRAGMENT = /* glsl */ `
precision highp float;
uniform vec3 middle;
uniform vec3 edge;
uniform vec4 area; // of the viewport in pixels
out vec4 pixel;
void main() {
  vec2 at = (gl_FragCoord.xy - area.xy) / area.zw - vec2(0.5, 0.56);
  float out1 = smoothstep(0.0, 0.85, length(at * vec2(min(area.z / area.w, 1.4), 1.0)));
  // Less than one step of colour, so that no bands show.
  float grain = fract(sin(dot(gl_FragCoord.xy, vec2(12.9898, 78.233))) * 43758.5453) - 0.5;
  pixel = vec4(mix(middle, edge, out1) + grain / 255.0, 1.0);
}
`;
