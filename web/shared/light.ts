// GLSL of the light that faces stand in.

/**
 * `studio`: a warm key from the upper left, a cool fill, a rim from behind and a soft dome.
 * All directions are those of the camera, so that a face is lit well from wherever it is seen.
 */
export const LIGHT = /* glsl */ `
const vec3 KEY = vec3(-0.50, 0.60, 0.62);
const vec3 FILL = vec3(0.80, 0.02, 0.60);
const vec3 RIM = vec3(0.62, 0.44, -0.65);
const vec3 KEY_LIGHT = vec3(2.45, 2.30, 2.12);
const vec3 FILL_LIGHT = vec3(0.30, 0.36, 0.44);
const vec3 RIM_LIGHT = vec3(1.05, 1.10, 1.20);
const vec3 SKY = vec3(0.50, 0.54, 0.60);
const vec3 GROUND = vec3(0.20, 0.165, 0.15);

// Light that enters skin comes out beside where it went in, red farthest: the terminator is soft
// and warm.
vec3 softened(float lit, float soft) {
  vec3 wrap = soft * vec3(0.32, 0.17, 0.12);
  vec3 d = max((vec3(lit) + wrap) / (1.0 + wrap), 0.0);
  return d * mix(vec3(1.0), d, 0.35 * soft);
}

float highlight(vec3 n, vec3 v, vec3 l, float roughness) {
  vec3 h = normalize(l + v);
  float a = roughness * roughness;
  float nh = max(dot(n, h), 0.0);
  float nl = max(dot(n, l), 0.0);
  float nv = max(dot(n, v), 1e-3);
  float lobe = a / (nh * nh * (a * a - 1.0) + 1.0);
  float seen = 0.25 / (mix(nl, 1.0, a) * mix(nv, 1.0, a));
  float fresnel = 0.035 + 0.965 * pow(1.0 - max(dot(v, h), 0.0), 5.0);
  return nl * min(lobe * lobe * seen * fresnel / 3.14159 * 4.0, 6.0);
}

// How much light comes where the surface is hollow: −1 on ridges to 1 in creases.
float opened(float hollow) {
  return clamp(1.0 - 2.1 * max(hollow, 0.0), 0.35, 1.0) * (1.0 + 0.5 * max(-hollow, 0.0));
}

// reached: share of the key light.
vec3 inStudio(vec3 colour, float shine, float roughness, float open, float reached, vec3 n, vec3 v) {
  float soft = shine < 0.7 ? 1.0 : 0.35;
  vec3 crease = mix(colour * vec3(1.0, 0.82, 0.78), vec3(1.0), open);
  vec3 dome = mix(GROUND, SKY, smoothstep(-1.0, 1.0, n.y)) * open * mix(0.62, 1.0, reached);
  vec3 key = KEY_LIGHT * mix(vec3(reached), pow(vec3(reached), vec3(0.72, 0.96, 1.0)), soft);
  float edge = pow(1.0 - max(dot(n, v), 0.0), 3.0);
  vec3 light = dome
    + key * softened(dot(n, normalize(KEY)), soft) * mix(0.55, 1.0, open)
    + FILL_LIGHT * softened(dot(n, normalize(FILL)), soft) * open
    + RIM_LIGHT * max(dot(n, normalize(RIM)), 0.0) * (0.2 + 0.8 * edge);
  vec3 shone = key * highlight(n, v, normalize(KEY), roughness)
    + FILL_LIGHT * highlight(n, v, normalize(FILL), roughness)
    + 0.10 * SKY * edge * open;
  return 0.50 * colour * light * crease + shine * open * shone;
}

vec3 studio(vec3 colour, float shine, float hollow, float reached, vec3 n, vec3 v) {
  float roughness = mix(0.62, 0.16, smoothstep(0.3, 1.0, shine));
  return inStudio(colour, shine, roughness, opened(hollow), reached, n, v);
}

// Bright parts bend over gently instead of being cut off.
vec3 toned(vec3 light) {
  vec3 x = 0.92 * light;
  return x * (1.0 + 0.12 * x) / (1.0 + 0.42 * x);
}

vec3 encoded(vec3 light) {
  vec3 c = clamp(light, 0.0, 1.0);
  return mix(1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, 12.92 * c, vec3(lessThanEqual(c, vec3(0.0031308))));
}
`;
