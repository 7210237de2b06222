// The shadow that a face casts on itself under the key light, which moves with the camera.

/** From the camera's space to that of the light: x and y in the map, z towards the light. */
export const LIGHT_SPACE = /* glsl */ `
uniform vec4 ball; // middle of the face in the camera's space, its radius
const vec3 TOWARDS = normalize(vec3(-0.50, 0.60, 0.62));
vec3 turned(vec3 way) {
  vec3 right = normalize(cross(vec3(0.0, 1.0, 0.0), TOWARDS));
  return transpose(mat3(right, cross(TOWARDS, right), TOWARDS)) * way;
}
vec3 inLight(vec3 view) {
  return turned(view - ball.xyz) / ball.w;
}
`;

/** How much of the key light reaches a point, 0 to 1: some looks, turned from pixel to pixel. */
export const SHADOW = /* glsl */ `
${LIGHT_SPACE}
uniform mediump sampler2DShadow shadows;
uniform int looks;
float lit(vec3 view, vec3 n) {
  if (dot(n, TOWARDS) < -0.35) return 0.22; // turned away, where no lamp reaches it anyway
  vec3 at = inLight(view + 0.012 * ball.w * n);
  vec3 place = vec3(at.xy, -at.z) * 0.5 + 0.5;
  // Each look compares with the depth of the surface there, or a slope would shade itself.
  vec3 up = turned(n);
  vec2 slope = up.xy / max(up.z, 0.25);
  float turn = 6.2832 * fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
  float sum = 0.0;
  for (int i = 0; i < looks; i += 1) {
    float away = sqrt((float(i) + 0.5) / float(looks)) * 0.012;
    float angle = turn + 2.399963 * float(i);
    vec2 aside = away * vec2(cos(angle), sin(angle));
    sum += texture(shadows, vec3(place.xy + aside, place.z + dot(slope, aside) - 0.0012));
  }
  return 0.22 + 0.78 * sum / float(looks); // the lamp is large: no shadow is black
}
`;

export const SHADOW_FRAGMENT = /* glsl */ `
precision mediump float;
out vec4 nothing;
void main() { nothing = vec4(0.0); }
`;
