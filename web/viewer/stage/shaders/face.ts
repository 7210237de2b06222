// How a face looks: its parts in light, or the colours of distances.
import { LIGHT } from '../../../shared/light';
import { DRESS } from './dress';
import { SHADOW } from './shadow';
import { VERTEX_FETCH } from './vertices';

export const FACE_VERTEX = /* glsl */ `
${VERTEX_FETCH}
in uvec2 corner; // vertex, part
#ifdef DRESSED
in vec2 uv; // texture coordinates, v from the top
in vec2 uv2;
in vec4 tinted; // what colours are multiplied with
in vec3 fileNormal; // of the neutral; none: 0
uniform sampler2D restNormals;
uniform bool isTinted;
out vec4 places; // on images: two sets of coordinates
out vec4 tinge;
#endif
uniform mat4 modelViewMatrix;
uniform mat4 projectionMatrix;
uniform sampler2D positions;
uniform sampler2D normals;
uniform sampler2D rest; // of the neutral, for what is drawn on the skin
uniform sampler2D against; // of the face compared with
uniform bool painting; // whether something is drawn on the skin
uniform bool measuring; // whether the distance is wanted
centroid out vec3 seen;
centroid out vec3 normal;
centroid out vec3 atRest;
centroid out float hollow;
centroid out float away; // distance from the face compared with
flat out int part;
void main() {
  vec3 position = ofVertex(positions, corner.x).xyz;
  vec4 bent = ofVertex(normals, corner.x);
  vec4 view = modelViewMatrix * vec4(position, 1.0);
  seen = view.xyz;
  vec3 turned = bent.xyz;
#ifdef DRESSED
  // What the file's normals add to those of the shape at rest, they add to them as it moves.
  if (dot(fileNormal, fileNormal) > 0.1) turned += fileNormal - ofVertex(restNormals, corner.x).xyz;
  places = vec4(uv, uv2);
  tinge = isTinted ? tinted : vec4(1.0);
#endif
  normal = mat3(modelViewMatrix) * turned;
  hollow = bent.w;
  atRest = painting ? ofVertex(rest, corner.x).xyz : vec3(0.0);
  away = measuring ? distance(position, ofVertex(against, corner.x).xyz) : 0.0;
  part = int(corner.y);
  gl_Position = projectionMatrix * view;
}
`;

const INPUTS = /* glsl */ `
precision highp float;
precision highp sampler2D;
// Centroid: at the outline a pixel's middle may lie beside the face, where normals turn away.
centroid in vec3 seen;
centroid in vec3 normal;
centroid in vec3 atRest;
centroid in float hollow;
centroid in float away;
flat in int part;
uniform bool flatShading;
out vec4 pixel;
// Whether the inner side is seen. At the outline triangles turn away before the surface does.
bool inner() {
  return !gl_FrontFacing && dot(normalize(normal), normalize(seen)) > 0.15;
}
vec3 facing() {
  vec3 n = flatShading ? cross(dFdx(seen), dFdy(seen)) : normal;
  n = normalize(n);
  if (flatShading) return dot(n, seen) > 0.0 ? -n : n;
  return inner() ? -n : n;
}
`;

export const FACE_FRAGMENT = /* glsl */ `
${INPUTS}
${LIGHT}
${SHADOW}
uniform sampler2D parts; // colour and shine above, middle and radius of an eye below
uniform sampler2D matcap;
uniform sampler2D heat;
uniform bool inMatcap;
uniform bool painting;
uniform bool measuring;
uniform float heatTop;
#ifdef DRESSED
${DRESS}
#endif

// An iris on an eyeball that has none; distances are in its radius.
vec3 painted(vec3 white, vec4 eye) {
  vec3 from = (atRest - eye.xyz) / eye.w;
  if (eye.w <= 0.0 || from.z <= 0.0) return white;
  float out1 = length(from.xy);
  float turn = atan(from.y, from.x);
  float width = fwidth(out1) + 0.008;
  float inward = clamp((0.47 - out1) / 0.29, 0.0, 1.0);
  float spokes = 0.5 * sin(47.0 * turn) * sin(23.0 * turn + 1.0) + 0.35 * sin(71.0 * turn + 2.0);
  vec3 iris = mix(vec3(0.022, 0.034, 0.042), vec3(0.115, 0.165, 0.195), smoothstep(0.0, 0.4, inward));
  iris = mix(iris, vec3(0.19, 0.20, 0.15), 0.6 * smoothstep(0.5, 1.0, inward)) * (1.0 + 0.22 * spokes);
  iris = mix(vec3(0.004), iris, smoothstep(0.18 - width, 0.18 + width, out1));
  return mix(iris, white, smoothstep(0.47 - width, 0.47 + width, out1));
}

void main() {
  vec3 n = facing();
  vec3 v = normalize(-seen);
  vec4 look = texelFetch(parts, ivec2(part, 0), 0);
  vec3 colour = painting ? painted(look.rgb, texelFetch(parts, ivec2(part, 1), 0)) : look.rgb;
  float opacity = 1.0;
#ifdef DRESSED
  float inside = 1.0;
  vec4 base = basis();
  if (base.a < cutoff) discard;
  opacity = max(base.a, solid);
  colour = base.rgb;
  n = bumped(n);
#else
  float inside = inner() ? 0.28 : 1.0;
#endif
  if (measuring) {
    // Shape shows through, but a colour stays that of the legend within what eyes tell apart.
    float shade = 0.70 + 0.34 * clamp(dot(n, normalize(vec3(-0.3, 0.4, 0.86))), 0.0, 1.0) - 0.6 * max(hollow, 0.0);
    vec3 c = texture(heat, vec2(clamp(away / heatTop, 0.0, 1.0) * (255.0 / 256.0) + 0.5 / 256.0, 0.5)).rgb;
    pixel = vec4(c * shade * mix(0.5, 1.0, inside), opacity);
    return;
  }
  vec3 light;
  if (inMatcap) {
    vec3 across = normalize(vec3(v.z, 0.0, -v.x));
    vec2 at = vec2(dot(across, n), dot(cross(v, across), n)) * 0.49 + 0.5;
    float open = clamp(1.0 - 2.4 * max(hollow, 0.0), 0.3, 1.0) * (1.0 + 0.9 * max(-hollow, 0.0));
    vec3 tint = mix(vec3(1.0), min(colour / vec3(0.656, 0.42, 0.319), 1.3), 0.85);
    light = texture(matcap, at).rgb * tint * open;
  } else {
#ifdef DRESSED
    light = dressed(colour, opened(hollow), n, v);
#else
    light = toned(studio(colour, look.a, hollow, lit(seen, n), n, v));
#endif
  }
  pixel = vec4(encoded(light * inside), opacity);
}
`;

/** A face that is not there: only where it is apart from the one that is. */
export const GHOST_FRAGMENT = /* glsl */ `
${INPUTS}
uniform vec3 tint;
uniform float opacity;
uniform float apart; // distance at which it is fully there
void main() {
  float there = smoothstep(0.15, 1.0, away / apart);
  if (there < 0.03) discard;
  vec3 n = facing();
  float edge = 1.0 - abs(dot(n, normalize(-seen)));
  float lit = 0.62 + 0.38 * clamp(dot(n, normalize(vec3(-0.5, 0.5, 0.7))), 0.0, 1.0);
  pixel = vec4(mix(tint * lit, tint, edge), there * opacity * mix(0.75, 1.7, edge * edge));
}
`;
