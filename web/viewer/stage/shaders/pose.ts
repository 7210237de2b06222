// Posing: one fragment a vertex.
import { VERTEX_FETCH } from './vertices';

/** Covers the whole of a render target with one triangle. */
export const COVER = /* glsl */ `
void main() { gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0); }
`;

/** V₀ + Σ weight · target over the targets that move something; nothing is spent on the others. */
export const POSITIONS = /* glsl */ `
${VERTEX_FETCH}
uniform sampler2D neutral;
uniform sampler2D targets; // the rows of one target below those of another
uniform sampler2D moving; // number of a target, its weight
uniform int movingCount;
out vec4 position;
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  int rows = textureSize(neutral, 0).y;
  vec3 sum = texelFetch(neutral, at, 0).xyz;
  for (int i = 0; i < movingCount; i += 1) {
    vec2 entry = texelFetch(moving, ivec2(i, 0), 0).xy;
    sum += entry.y * texelFetch(targets, at + ivec2(0, rows * int(entry.x)), 0).xyz;
  }
  position = vec4(sum, 1.0);
}
`;

/**
 * The mean of the triangles round a vertex, weighted by their angles there, so that it does not
 * depend on how polygons were cut; w is how hollow the surface is, −1 to 1.
 */
export const NORMALS = /* glsl */ `
${VERTEX_FETCH}
uniform sampler2D positions;
uniform usampler2D rings; // first corner of each vertex, their number
uniform usampler2D corners; // the vertices after and before
out vec4 normal;
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec3 here = texelFetch(positions, at, 0).xyz;
  uvec2 ring = texelFetch(rings, at, 0).xy;
  int width = textureSize(corners, 0).x;
  vec3 sum = vec3(0.0);
  vec3 around = vec3(0.0);
  float reach = 0.0;
  for (uint i = 0u; i < ring.y; i += 1u) {
    uvec2 corner = texelFetch(corners, texelOf(ring.x + i, width), 0).xy;
    vec3 after = ofVertex(positions, corner.x).xyz - here;
    vec3 before = ofVertex(positions, corner.y).xyz - here;
    vec3 area = cross(after, before);
    float size = length(area);
    if (size > 0.0) sum += area * (atan(size, dot(after, before)) / size);
    around += after + before;
    reach += length(after) + length(before);
  }
  float size = length(sum);
  vec3 direction = size > 1e-9 ? sum / size : vec3(0.0, 0.0, 1.0);
  normal = vec4(direction, reach > 0.0 ? clamp(dot(direction, around) / reach, -1.0, 1.0) : 0.0);
}
`;
