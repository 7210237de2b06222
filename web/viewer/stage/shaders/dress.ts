// What a file says of the looks of a surface: its images, its finish, its light and shade.

/** The images of a surface in the order of their places in `onto` and `set`. */
export const LAYERS = ['base', 'bumps', 'glow', 'finish', 'creases', 'shade'] as const;

export const DRESS = /* glsl */ `
uniform sampler2D base;
uniform sampler2D bumps;
uniform sampler2D glow;
uniform sampler2D finish; // roughness in green, metal in blue
uniform sampler2D creases; // in red
uniform sampler2D shade;
uniform mat3 onto[6]; // from texture coordinates to the image
uniform int set[6]; // of the coordinates; less than 0 where there is no image
uniform vec4 tint; // colour and opacity that the image is multiplied with
uniform float cutoff; // least opacity that is shown
uniform float solid; // 1 where nothing shines through
uniform int shading; // 0 in light, 1 as it is, 2 in light and shade of flat colours
uniform float bumpScale;
uniform vec3 glowing;
uniform float rough;
uniform float metallic;
uniform float shine; // of what is no metal, beside what is usual
uniform float creaseDepth;
uniform vec3 shadeTint;
uniform vec2 edge; // of the shade: cosines to the light
in vec4 places;
in vec4 tinge;

vec2 at(int layer) {
  return (onto[layer] * vec3(set[layer] == 1 ? places.zw : places.xy, 1.0)).xy;
}

vec4 basis() {
  return tint * tinge * (set[0] < 0 ? vec4(1.0) : texture(base, at(0)));
}

// The axes of the image on the surface come from how places change from pixel to pixel.
vec3 bumped(vec3 n) {
  if (set[1] < 0) return n;
  vec2 place = at(1);
  vec3 bump = texture(bumps, place).xyz * 2.0 - 1.0;
  vec3 right = dFdx(seen), up = dFdy(seen);
  vec2 toRight = dFdx(place), toUp = dFdy(place);
  vec3 along = cross(up, n) * toRight.x + cross(n, right) * toUp.x;
  vec3 down = cross(up, n) * toRight.y + cross(n, right) * toUp.y;
  float size = max(dot(along, along), dot(down, down));
  if (size == 0.0) return n;
  bump.xy *= bumpScale * inversesqrt(size) * (inner() ? -1.0 : 1.0);
  return normalize(along * bump.x - down * bump.y + n * bump.z);
}

float spot(vec3 towards, vec3 way, float roughness) {
  return pow(max(dot(towards, normalize(way)), 0.0), mix(90.0, 1.5, sqrt(roughness)));
}

// What is around a metal: sky, ground and lamps, as blurred as it is rough.
vec3 mirrored(vec3 colour, float roughness, float open, float reached, vec3 n, vec3 v) {
  vec3 r = reflect(-v, n);
  float blur = mix(0.12, 1.0, roughness);
  vec3 around = mix(GROUND, SKY, smoothstep(-blur, blur, r.y))
    + reached * KEY_LIGHT * spot(r, KEY, roughness)
    + FILL_LIGHT * spot(r, FILL, roughness)
    + RIM_LIGHT * spot(r, RIM, roughness);
  return 0.55 * colour * around * open;
}

vec3 dressed(vec3 colour, float open, vec3 n, vec3 v) {
  vec3 own = set[2] < 0 ? glowing : glowing * texture(glow, at(2)).rgb;
  if (shading == 1) return colour;
  float reached = lit(seen, n);
  if (shading == 2) {
    vec3 dark = shadeTint * (set[5] < 0 ? vec3(1.0) : texture(shade, at(5)).rgb);
    float bright = clamp((dot(n, normalize(KEY)) - edge.x) / (edge.y - edge.x), 0.0, 1.0);
    return mix(dark, colour, bright * smoothstep(0.35, 0.75, reached)) + own;
  }
  vec2 found = set[3] < 0 ? vec2(1.0) : texture(finish, at(3)).gb;
  float roughness = clamp(rough * found.x, 0.05, 1.0);
  float metal = clamp(metallic * found.y, 0.0, 1.0);
  if (set[4] >= 0) open *= mix(1.0, texture(creases, at(4)).r, creaseDepth);
  vec3 skin = inStudio(colour, shine * mix(0.65, 0.06, roughness), max(roughness, 0.16), open, reached, n, v);
  return toned(mix(skin, mirrored(colour, roughness, open, reached, n, v), metal) + own);
}
`;
